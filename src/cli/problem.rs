//! Why a command ended without its result, in words for the user.

use std::fmt::Display;

use super::Exit;

/// An error message with its exit code.
#[derive(Debug)]
pub(super) struct Problem {
    pub(super) exit: Exit,
    /// Empty where all has been said already.
    pub(super) message: String,
    /// What to do about it, a line each.
    pub(super) help: Vec<String>,
}

impl Problem {
    pub(super) fn new(exit: Exit, message: impl Display) -> Self {
        Self { exit, message: message.to_string(), help: Vec::new() }
    }

    /// The user knows already; only the exit code is left.
    pub(super) fn told(exit: Exit) -> Self {
        Self { exit, message: String::new(), help: Vec::new() }
    }

    pub(super) fn with_help(mut self, help: impl Display) -> Self {
        self.help.push(help.to_string());
        self
    }
}
