//! Short forms of two and three letters (`-pre`, `-id`, `-od`). Clap does not know them, so they
//! become their long options before clap sees them.

use std::collections::HashSet;
use std::ffi::{OsStr, OsString};

use clap::{Arg, Command};

/// Short forms and their long options.
const SHORT_FORMS: [(&str, &str); 3] =
    [("-pre", "--prefix"), ("-id", "--indir"), ("-od", "--outdir")];

/// Writes out the short forms in `args`, which begin with the program's name: `-od x` becomes
/// `--outdir x`, `-od=x` becomes `--outdir=x`. Values of options and everything after `--` stay as
/// they are. The options of `command`, or of its called subcommand, decide which arguments are
/// values.
pub(crate) fn written_out(
    args: impl IntoIterator<Item = OsString>,
    command: &Command,
) -> Vec<OsString> {
    let args: Vec<OsString> = args.into_iter().collect();
    let options = ValueOptions::of(called(&args, command));
    let mut args = args.into_iter();
    let mut result: Vec<OsString> = args.next().into_iter().collect();
    while let Some(arg) = args.next() {
        if arg == "--" {
            result.push(arg);
            break;
        }
        let arg = long_form(&arg).unwrap_or(arg);
        let value = if options.takes_next(&arg) { args.next() } else { None };
        result.push(arg);
        result.extend(value);
    }
    result.extend(args);
    result
}

/// Returns the long form of `arg`, if it is a short form.
fn long_form(arg: &OsStr) -> Option<OsString> {
    let text = arg.to_str()?;
    SHORT_FORMS.iter().find_map(|(short, long)| {
        let rest = text.strip_prefix(short)?;
        (rest.is_empty() || rest.starts_with('=')).then(|| format!("{long}{rest}").into())
    })
}

/// Returns the called subcommand, or the command itself if none is called.
pub(crate) fn called<'a>(args: &[OsString], command: &'a Command) -> &'a Command {
    args.get(1).and_then(|name| command.find_subcommand(name)).unwrap_or(command)
}

/// Options of a command that take a value, which may be the next argument.
pub(crate) struct ValueOptions {
    long: HashSet<String>,
    short: HashSet<char>,
}

impl ValueOptions {
    pub(crate) fn of(command: &Command) -> Self {
        // A value that must be joined with `=` is not a separate argument.
        let takes_next =
            |arg: &&Arg| arg.get_action().takes_values() && !arg.is_require_equals_set();
        let with_value = || command.get_arguments().filter(takes_next);
        let names = with_value().filter_map(Arg::get_long);
        let aliases = with_value().flat_map(|arg| arg.get_all_aliases().unwrap_or_default());
        Self {
            long: names.chain(aliases).map(str::to_owned).collect(),
            short: with_value().filter_map(Arg::get_short).collect(),
        }
    }

    /// Whether the argument after `arg` is the value of an option in `arg`.
    pub(crate) fn takes_next(&self, arg: &OsStr) -> bool {
        let Some(text) = arg.to_str() else { return false };
        if let Some(name) = text.strip_prefix("--") {
            return self.long.contains(name);
        }
        let Some(cluster) = text.strip_prefix('-') else { return false };
        let first = cluster.char_indices().find(|(_, c)| self.short.contains(c));
        first.is_some_and(|(at, c)| at + c.len_utf8() == cluster.len())
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;
    use crate::cli::args::program::Args;

    fn check(typed: &str, expected: &str) {
        let args = format!("slo-rt {typed}");
        let result = written_out(args.split(' ').map(OsString::from), &Args::command());
        let result: Vec<_> = result.iter().map(|arg| arg.to_str().unwrap()).collect();
        assert_eq!(result[1..].join(" "), expected, "typed {typed}");
    }

    #[test]
    fn short_forms_are_written_out() {
        check("-pre a -id b -od c", "--prefix a --indir b --outdir c");
        check("-pre=a -id= -od=c=d", "--prefix=a --indir= --outdir=c=d");
        check(
            "-f 15 -s animace.txt --info -id in -od out",
            "-f 15 -s animace.txt --info --indir in --outdir out",
        );
    }

    #[test]
    fn values_stay() {
        check("-s -id -od out", "-s -id --outdir out");
        check("--prefix -pre -pre -pre", "--prefix -pre --prefix -pre");
        check("-pre -od -od -pre", "--prefix -od --outdir -pre");
        check("--outdit -id -id -od", "--outdit -id --indir -od");
        check("-if -id -id x", "-if -id --indir x");
        check("-f5 -id x", "-f5 --indir x");
        check("--frame=5 -id x", "--frame=5 --indir x");
        check("--size -od -od x", "--size -od --outdir x");
    }

    #[test]
    fn flags_take_nothing() {
        check("-i -id x", "-i --indir x");
        check("--info -id x -q -od y", "--info --indir x -q --outdir y");
    }

    #[test]
    fn a_value_that_has_to_be_joined_is_not_the_next_argument() {
        check("--share -od x", "--share --outdir x");
        check("--share=5 -od x -id y", "--share=5 --outdir x --indir y");
        // The loop covers all options of this kind, including future ones.
        let command = Args::command();
        let joined = command.get_arguments().filter(|arg| arg.is_require_equals_set());
        for name in joined.filter_map(Arg::get_long) {
            for (short, long) in SHORT_FORMS {
                check(&format!("--{name} {short} x"), &format!("--{name} {long} x"));
            }
        }
    }

    #[test]
    fn commands_have_options_of_their_own() {
        check("denoise --library -od -od x", "denoise --library -od --outdir x");
        check("verify --tiles -id -id x", "verify --tiles -id --indir x");
        check("merge -q -od x", "merge -q --outdir x");
        check("sheet -o -od -od x", "sheet -o -od --outdir x");
    }

    #[test]
    fn nothing_changes_after_two_dashes() {
        check("-id x -- -id -od", "--indir x -- -id -od");
        check("-s -- -id x", "-s -- --indir x");
    }

    #[test]
    fn other_arguments_stay() {
        check("-prefix -idx -o -d -p - ---", "-prefix -idx -o -d -p - ---");
        check("-šid --šid", "-šid --šid");
    }

    #[test]
    fn no_arguments_and_no_program_name() {
        assert!(written_out([], &Args::command()).is_empty());
    }

    #[cfg(unix)]
    #[test]
    fn arguments_that_are_no_text_stay() {
        use std::os::unix::ffi::OsStringExt;
        let odd = OsString::from_vec(vec![b'-', 0xff]);
        let args = [OsString::from("slo-rt"), odd.clone(), "-id".into(), odd.clone()];
        let result = written_out(args, &Args::command());
        assert_eq!(result[1..], [odd.clone(), "--indir".into(), odd]);
    }
}
