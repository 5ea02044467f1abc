//! Reasons why a command failed, in words for the user.

use std::fmt::Display;

use super::exit::Exit;

/// An error message with its exit code.
#[derive(Debug)]
pub(crate) struct Problem {
    pub(crate) exit: Exit,
    /// Empty if the problem was already reported.
    pub(crate) message: String,
    /// Advice on what to do, one item per line.
    pub(crate) help: Vec<String>,
}

impl Problem {
    pub(crate) fn new(exit: Exit, message: impl Display) -> Self {
        Self { exit, message: message.to_string(), help: Vec::new() }
    }

    /// Makes a problem that was already reported. Only the exit code is left.
    pub(crate) fn told(exit: Exit) -> Self {
        Self { exit, message: String::new(), help: Vec::new() }
    }

    /// Returns the message, with its frame named once.
    pub(crate) fn of_frame(&self, frame: i64) -> String {
        let (name, message) = (format!("frame {frame}"), &self.message);
        let after = message.strip_prefix(&name);
        let tells = after.is_some_and(|after| !after.starts_with(|c: char| c.is_ascii_digit()));
        if tells { message.clone() } else { format!("{name}: {message}") }
    }

    pub(crate) fn with_help(mut self, help: impl Display) -> Self {
        self.help.push(help.to_string());
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_named_once() {
        let check = |message: &str, expected: &str| {
            assert_eq!(Problem::new(Exit::Failed, message).of_frame(10), expected);
        };
        check("can't be", "frame 10: can't be");
        check("frame 10 is not in the scene", "frame 10 is not in the scene");
        check("frame 101 is no 10", "frame 10: frame 101 is no 10");
    }
}
