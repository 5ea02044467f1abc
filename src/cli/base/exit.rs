//! Exit codes.

use std::process::ExitCode;

/// Exit code of the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// Everything was done.
    Done = 0,
    /// Rendering failed, a file could not be read or written, or frames of a sequence failed.
    Failed = 1,
    /// The command line is wrong, or names a frame that the scene does not have.
    Usage = 2,
    /// The scene, or one of its meshes or textures, has errors.
    BadInput = 65,
    /// An input file is missing or can't be read.
    NoInput = 66,
    /// The GPU that the settings ask for is missing, or cannot take the scene.
    Unavailable = 69,
    /// The output can't be created, or a file that slo-rt did not make has its name.
    CantCreate = 73,
    /// Writing failed.
    CantWrite = 74,
    /// Stopped on purpose; the same command continues from there.
    Stopped = 75,
    /// Ended at once by a second signal.
    Interrupted = 130,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}
