//! The command line: arguments as typed -> validated options -> commands and exit codes.

use std::ffi::OsString;
use std::process::ExitCode;

/// What the program tells its caller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// Everything asked for was done.
    Done = 0,
    /// Rendering failed, or a file could not be read or written.
    Failed = 1,
    /// The command line is wrong.
    Usage = 2,
    /// The scene, or a mesh or texture of it, has errors.
    BadInput = 65,
    /// An input file is missing.
    NoInput = 66,
    /// The output can't be created; found before rendering starts.
    CantCreate = 73,
    /// Interrupted.
    Interrupted = 130,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

/// Runs the program with its arguments, the program's name first.
pub fn run(_args: impl IntoIterator<Item = OsString>) -> Exit {
    Exit::Done
}
