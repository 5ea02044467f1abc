//! Tips for correcting a wrong command line.

use std::ffi::{OsStr, OsString};

use clap::builder::StyledStr;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, Command, Error};

use super::short_forms::{ValueOptions, called};

/// Option names of other programs, and the names of the same options here.
const ELSEWHERE: [(&str, &str); 14] = [
    ("--output", "--outdir"),
    ("--output-dir", "--outdir"),
    ("--out", "--outdir"),
    ("-o", "--outdir"),
    ("--input", "--scene"),
    ("-i", "--scene"),
    ("--resolution", "--size"),
    ("--width", "--size"),
    ("--height", "--size"),
    ("--spp", "--samples"),
    ("--jobs", "--threads"),
    ("-j", "--threads"),
    ("-t", "--threads"),
    ("--force", "--overwrite"),
];

/// Adds a helpful tip to the error, if there is one. The short forms in `args` are written out,
/// and the program's name comes first.
pub(crate) fn with_tip(error: Error, args: &[OsString], mut command: Command) -> Error {
    command.build();
    let command = called(args, &command);
    match error.kind() {
        ErrorKind::InvalidUtf8 => no_text(args, error, command),
        ErrorKind::InvalidSubcommand | ErrorKind::ArgumentConflict => {
            match text(&error, ContextKind::InvalidSubcommand) {
                Some(word) if command.find_subcommand(&word).is_none() => {
                    let tip = tip_of_word(&word, args, command);
                    unknown(command, &word, tip)
                }
                _ => error,
            }
        }
        ErrorKind::UnknownArgument => match text(&error, ContextKind::InvalidArg) {
            Some(word) if !word.starts_with('-') => {
                let tip = tip_of_word(&word, args, command);
                unknown(command, &word, tip)
            }
            Some(word) => of_option(error, &word, args, command),
            None => error,
        },
        _ => error,
    }
}

fn text(error: &Error, kind: ContextKind) -> Option<String> {
    match error.get(kind)? {
        ContextValue::String(text) => Some(text.clone()),
        _ => None,
    }
}

/// Makes the error for an unknown argument.
fn unknown(command: &Command, word: &str, tip: Option<String>) -> Error {
    let mut error = Error::new(ErrorKind::UnknownArgument).with_cmd(command);
    error.insert(ContextKind::InvalidArg, ContextValue::String(word.to_owned()));
    set_tip(&mut error, tip);
    error
}

fn set_tip(error: &mut Error, tip: Option<String>) {
    error.remove(ContextKind::SuggestedArg);
    match tip {
        Some(tip) => {
            let tip = ContextValue::StyledStrs(vec![StyledStr::from(tip)]);
            error.insert(ContextKind::Suggested, tip);
        }
        None => drop(error.remove(ContextKind::Suggested)),
    }
}

/// Makes the tip for a word without an option. The word is a value that should have been joined,
/// or most likely a scene, if the command takes one.
fn tip_of_word(word: &str, args: &[OsString], command: &Command) -> Option<String> {
    let at = args.iter().position(|arg| arg == word)?;
    if args[at - at.min(1)] == "--share" {
        return Some(format!("join the value of '--share' with `=`: '--share={word}'"));
    }
    if command.get_name() == "import" {
        return Some("import one file at a time".into());
    }
    let has_scene = command.get_arguments().any(|arg| is_named(arg, "--scene"));
    has_scene.then(|| format!("name a scene file with an option: '--scene {word}'"))
}

/// Adds the tip to the error for an unknown option.
fn of_option(mut error: Error, word: &str, args: &[OsString], command: &Command) -> Error {
    if let Some(tip) = tip_of_value(word, args, command) {
        set_tip(&mut error, Some(tip));
        return error;
    }
    let has = |name: &str| command.get_arguments().any(|arg| is_named(arg, name));
    let known = ELSEWHERE.into_iter().find(|(elsewhere, here)| *elsewhere == word && has(here));
    let suggested = text(&error, ContextKind::SuggestedArg);
    let here = known.map(|(_, here)| here.to_owned()).or_else(|| {
        let suggested = suggested?;
        Some(real_name(command, &suggested).unwrap_or(suggested))
    });
    set_tip(&mut error, here.map(|name| format!("use the option '{name}'")));
    error
}

/// Makes the tip for a value that begins with a minus sign and was taken for an option.
fn tip_of_value(word: &str, args: &[OsString], command: &Command) -> Option<String> {
    let options = ValueOptions::of(command);
    let pairs = args.windows(2).map(|pair| (&pair[0], &pair[1]));
    let is_it = |value: &OsStr| value.to_str().is_some_and(|value| value.starts_with(word));
    let mut pairs = pairs.filter(|(option, value)| options.takes_next(option) && is_it(value));
    let (option, value) = pairs.next()?;
    let (option, value) = (option.to_str()?, value.to_str()?);
    Some(format!("join a value that begins with `-` with `=`: '{option}={value}'"))
}

fn is_named(arg: &Arg, name: &str) -> bool {
    arg.get_long().is_some_and(|long| name.strip_prefix("--") == Some(long))
}

/// Returns the visible name of the option with the hidden name `alias`.
fn real_name(command: &Command, alias: &str) -> Option<String> {
    let alias = alias.strip_prefix("--")?;
    let has_alias =
        |arg: &&Arg| arg.get_all_aliases().is_some_and(|aliases| aliases.contains(&alias));
    let arg = command.get_arguments().find(has_alias)?;
    Some(format!("--{}", arg.get_long()?))
}

/// Makes the error for an argument that is not text.
fn no_text(args: &[OsString], error: Error, command: &Command) -> Error {
    let Some(arg) = args.iter().find(|arg| arg.to_str().is_none()) else { return error };
    let message = format!("the argument {arg:?} is not valid UTF-8");
    Error::raw(ErrorKind::InvalidUtf8, message + "\n").with_cmd(command)
}

#[cfg(test)]
mod tests {
    use clap::{CommandFactory, FromArgMatches};

    use super::*;
    use crate::cli::args::program::Args;
    use crate::cli::args::short_forms::written_out;

    fn told_of(args: Vec<OsString>) -> String {
        let command = Args::command();
        let args = written_out(args, &command);
        let matches = command.clone().try_get_matches_from(&args);
        let error = matches.and_then(|matches| Args::from_arg_matches(&matches)).unwrap_err();
        with_tip(error, &args, command).to_string()
    }

    fn told(typed: &str) -> String {
        told_of(format!("slo-rt {typed}").split(' ').map(OsString::from).collect())
    }

    #[track_caller]
    fn check(typed: &str, tip: &str) {
        let told = told(typed);
        assert!(told.contains(&format!("tip: {tip}\n")), "{typed}: {told}");
    }

    #[test]
    fn a_bare_scene_gets_a_tip() {
        for typed in ["table.txt", "-f 3 table.txt", "table.txt -q", "--info -q table.txt"] {
            check(typed, "name a scene file with an option: '--scene table.txt'");
        }
    }

    #[test]
    fn commands_without_a_scene_get_no_tip_of_one() {
        check("import a.obj b.obj", "import one file at a time");
        assert!(!told("sheet -o a.png b.png --bad x").contains("--scene"));
    }

    #[test]
    fn a_value_that_is_not_joined_gets_a_tip() {
        check("--share 30", "join the value of '--share' with `=`: '--share=30'");
        check("-f 1-3 --share 30s -q", "join the value of '--share' with `=`: '--share=30s'");
        check("--outdir -x", "join a value that begins with `-` with `=`: '--outdir=-x'");
        check("-pre -take2", "join a value that begins with `-` with `=`: '--prefix=-take2'");
    }

    #[test]
    fn options_that_there_are_get_a_tip() {
        check("--scen x", "use the option '--scene'");
        check("--output a.png", "use the option '--outdir'");
        check("-o out", "use the option '--outdir'");
        check("--outdirr x", "use the option '--outdir'");
        check("--spp 64", "use the option '--samples'");
        check("merge a.part --output x", "use the option '--outdir'");
        assert!(!told("compare a b --output x").contains("outdir"));
    }

    #[test]
    fn no_tip_names_a_hidden_name() {
        let args = Args::command();
        let commands = args.get_subcommands().map(|command| format!("{} a b ", command.get_name()));
        let commands: Vec<String> = commands.chain([String::new()]).collect();
        let hidden: Vec<&str> =
            args.get_arguments().filter_map(Arg::get_all_aliases).flatten().collect();
        assert_eq!(hidden, ["outdit"]);
        for command in commands {
            for name in ["output", "outdi", "outdat", "outdits", "outdti", "oudit", "outdirs"] {
                let has_output = ["sheet", "relight"].iter().any(|with| command.starts_with(with));
                if has_output && name == "output" {
                    continue;
                }
                let told = told(&format!("{command}--{name} x"));
                assert!(!told.contains("'--outdit'"), "{command}{name}: {told}");
            }
        }
    }

    #[cfg(unix)]
    #[test]
    fn arguments_that_are_no_text_are_named() {
        use std::os::unix::ffi::OsStringExt;
        let odd = OsString::from_vec(b"a\xff".to_vec());
        let told = told_of(vec!["slo-rt".into(), "--prefix".into(), odd]);
        assert!(told.contains("the argument \"a\\xFF\" is not valid UTF-8"), "{told}");
    }
}
