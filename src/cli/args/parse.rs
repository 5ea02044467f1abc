//! Parses the arguments as typed into [`Args`], or prints help or an error.

use std::ffi::OsString;
use std::io::{self, Write};

use clap::error::ErrorKind;
use clap::{ColorChoice, Command, CommandFactory, Error, FromArgMatches};

use super::program::Args;
use super::short_forms::written_out;
use super::tips::with_tip;
use crate::cli::base::{Exit, say};

/// Parses `args`, which begin with the program's name. Prints help and version to standard output
/// and errors to standard error.
///
/// # Errors
/// The exit code, if help, the version or an error was printed and nothing is left to do.
pub(crate) fn parse(args: &[OsString]) -> Result<Args, Exit> {
    try_parse(args).map_err(|error| {
        let what = match error.kind() {
            ErrorKind::DisplayHelp => Some("help"),
            ErrorKind::DisplayVersion => Some("version"),
            _ => None,
        };
        let printed = error.print().and_then(|()| io::stdout().flush());
        match (what, printed) {
            (None, _) => Exit::Usage,
            (Some(what), Err(error)) if error.kind() != io::ErrorKind::BrokenPipe => {
                say(format_args!("error: can't print the {what}: {error}"));
                Exit::Failed
            }
            (Some(_), _) => Exit::Done,
        }
    })
}

/// The command line, as clap knows it.
pub(crate) fn command_line() -> Command {
    Args::command()
}

fn try_parse(args: &[OsString]) -> Result<Args, Error> {
    let command = command_line().color(color_choice(args));
    let args = written_out(args.iter().cloned(), &command);
    let matches = command.clone().try_get_matches_from(&args);
    let parsed = matches.and_then(|matches| Args::from_arg_matches(&matches));
    parsed.map_err(|error| with_tip(error, &args, command))
}

/// Finds the value of `--color`, even if the other arguments are wrong.
fn color_choice(args: &[OsString]) -> ColorChoice {
    let mut values = args.iter().enumerate().filter_map(|(at, arg)| match arg.to_str()? {
        "--color" => args.get(at + 1)?.to_str(),
        arg => arg.strip_prefix("--color="),
    });
    match values.next().map(str::to_ascii_lowercase).as_deref() {
        Some("always") => ColorChoice::Always,
        Some("never") => ColorChoice::Never,
        _ => ColorChoice::Auto,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::values::{FrameChoice, Frames};

    fn arguments(typed: &str) -> Vec<OsString> {
        format!("slo-rt {typed}").trim().split(' ').map(OsString::from).collect()
    }

    #[test]
    fn the_command_lines_of_the_thesis() {
        let check = |typed: &str| try_parse(&arguments(typed)).unwrap();
        assert!(check("").scene.is_none());
        assert_eq!(check("--frame 5").frame, Some(FrameChoice::These(Frames::single(5))));
        assert_eq!(check("--scene animace.txt").scene, Some("animace.txt".into()));
        assert!(check("-f 15 -s animace.txt --info").info);
        let last = check("-f 15 -s animace.txt -id input/scenes -od output/animace -pre x");
        assert_eq!(last.indir, Some("input/scenes".into()));
        assert_eq!(last.outdir, Some("output/animace".into()));
        assert_eq!(last.prefix, Some("x".into()));
    }

    #[test]
    fn values_that_look_like_short_forms() {
        let error = try_parse(&arguments("-s -id x")).unwrap_err().to_string();
        assert!(error.contains("--scene <FILE>"), "{error}");
        assert_eq!(try_parse(&arguments("--prefix=-id")).unwrap().prefix, Some("-id".into()));
    }

    #[test]
    fn colour_is_known_before_the_rest() {
        let check = |typed: &str, expected| {
            assert_eq!(color_choice(&arguments(typed)), expected, "{typed}");
        };
        check("--nonsense --color never", ColorChoice::Never);
        check("--color=always", ColorChoice::Always);
        check("--color", ColorChoice::Auto);
        check("-s --colour", ColorChoice::Auto);
    }
}
