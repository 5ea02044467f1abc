//! Foundations of the command line: exit codes, problems, messages, and quantities in words.

mod exit;
mod problem;
mod quantities;
mod terminal;

pub use exit::Exit;
pub(crate) use problem::Problem;
pub(crate) use quantities::{counted, human, megabytes, whole};
pub(crate) use terminal::{Terminal, Verbosity, When, print, say};
