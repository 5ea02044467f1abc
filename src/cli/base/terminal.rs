//! Messages of the program: errors and notes on standard error, and results on standard output.
//!
//! Writing a message never fails: if standard error is closed, nobody reads it.

use std::fmt::Display;
use std::io::{self, IsTerminal, Write};

use clap::ValueEnum;
use clap::builder::styling::{AnsiColor, Style};

use slo_scene::diagnostics::Diagnostics;

/// `--color`: when messages have colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum When {
    #[default]
    Auto,
    Always,
    Never,
}

/// Amount of messages that the program prints.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Verbosity {
    Quiet,
    Normal,
    Verbose,
}

/// Settings for writing to standard error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Terminal {
    /// Whether messages have colours.
    pub(crate) color: bool,
    /// Whether lines can be overwritten: standard error is an interactive terminal that can move
    /// its cursor.
    pub(crate) interactive: bool,
    pub(crate) verbosity: Verbosity,
}

impl Terminal {
    pub(crate) fn new(when: When, verbosity: Verbosity) -> Self {
        let is_terminal = io::stderr().is_terminal();
        let variable = |name: &str| std::env::var_os(name).map(|v| v.to_string_lossy().into());
        Self {
            color: color(when, is_terminal, variable),
            interactive: is_terminal && !is_dumb(variable),
            verbosity,
        }
    }

    /// Prints a line, unless `--quiet` is set.
    pub(crate) fn note(self, text: impl Display) {
        if self.verbosity > Verbosity::Quiet {
            say(format_args!("slo-rt: {text}"));
        }
    }

    /// Prints a line only with `--verbose`.
    pub(crate) fn detail(self, text: impl Display) {
        if self.verbosity == Verbosity::Verbose {
            say(format_args!("        {text}"));
        }
    }

    /// Prints the errors and warnings of a scene.
    pub(crate) fn show(self, diagnostics: &Diagnostics) {
        let report = diagnostics.render(self.color);
        if !report.is_empty() {
            say(report.trim_end());
        }
    }

    pub(crate) fn warn(self, text: impl Display) {
        let style = self.style(AnsiColor::Yellow);
        say(format_args!("{style}warning{style:#}: {text}"));
    }

    pub(crate) fn error(self, text: impl Display, help: &[String]) {
        let style = self.style(AnsiColor::Red);
        say(format_args!("{style}error{style:#}: {text}"));
        let style = self.style(AnsiColor::Cyan);
        for line in help {
            say(format_args!("  {style}help{style:#}: {line}"));
        }
    }

    fn style(self, color: AnsiColor) -> Style {
        if self.color { color.on_default().bold() } else { Style::new() }
    }
}

/// Prints one line to standard error immediately.
pub(crate) fn say(line: impl Display) {
    let _ = writeln!(io::stderr(), "{line}");
}

/// Prints `text` and a line break to standard output. A closed pipe is not an error.
///
/// # Errors
/// Any other I/O error.
pub(crate) fn print(text: &[u8]) -> io::Result<()> {
    let mut out = io::stdout();
    let printed =
        out.write_all(text).and_then(|()| out.write_all(b"\n")).and_then(|()| out.flush());
    match printed {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other,
    }
}

/// Decides whether messages have colours: by `--color` first, then by `NO_COLOR`, `CLICOLOR_FORCE`
/// and `TERM` as <https://no-color.org> and <https://bixense.com/clicolors> define them, then by
/// whether standard error is a terminal.
fn color(when: When, is_terminal: bool, variable: impl Fn(&str) -> Option<String>) -> bool {
    let is_set = |name| variable(name).is_some_and(|value| !value.is_empty());
    match when {
        When::Always => true,
        When::Never => false,
        When::Auto if is_set("NO_COLOR") => false,
        When::Auto
            if is_set("CLICOLOR_FORCE") && variable("CLICOLOR_FORCE") != Some("0".into()) =>
        {
            true
        }
        When::Auto => is_terminal && !is_dumb(variable),
    }
}

fn is_dumb(variable: impl Fn(&str) -> Option<String>) -> bool {
    variable("TERM").is_some_and(|term| term == "dumb")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(when: When, is_terminal: bool, variables: &[(&str, &str)], expected: bool) {
        let variable = |name: &str| {
            let found = variables.iter().find(|(key, _)| *key == name);
            found.map(|(_, value)| (*value).to_owned())
        };
        let message = format!("{when:?}, terminal {is_terminal}, {variables:?}");
        assert_eq!(color(when, is_terminal, variable), expected, "{message}");
    }

    #[test]
    fn colour_follows_the_terminal() {
        check(When::Auto, true, &[], true);
        check(When::Auto, false, &[], false);
        check(When::Auto, true, &[("TERM", "xterm")], true);
        check(When::Auto, true, &[("TERM", "dumb")], false);
    }

    #[test]
    fn variables_overrule_the_terminal() {
        check(When::Auto, true, &[("NO_COLOR", "1")], false);
        check(When::Auto, true, &[("NO_COLOR", "")], true);
        check(When::Auto, false, &[("CLICOLOR_FORCE", "1")], true);
        check(When::Auto, false, &[("CLICOLOR_FORCE", "0")], false);
        check(When::Auto, false, &[("CLICOLOR_FORCE", "1"), ("TERM", "dumb")], true);
        check(When::Auto, true, &[("CLICOLOR_FORCE", "1"), ("NO_COLOR", "1")], false);
    }

    #[test]
    fn the_option_overrules_all() {
        check(When::Always, false, &[("NO_COLOR", "1"), ("TERM", "dumb")], true);
        check(When::Never, true, &[("CLICOLOR_FORCE", "1")], false);
    }

    #[test]
    fn plain_messages_have_no_escapes() {
        let plain = Terminal { color: false, interactive: false, verbosity: Verbosity::Normal };
        assert_eq!(plain.style(AnsiColor::Red).to_string(), "");
        let coloured = Terminal { color: true, ..plain };
        assert_ne!(coloured.style(AnsiColor::Red).to_string(), "");
    }
}
