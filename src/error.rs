//! Errors of opening a scene and of making a picture.

use std::fmt;
use std::io;
use std::path::PathBuf;

use slo_render::frame::FrameError;
use slo_scene::diagnostics::Diagnostics;

/// Why a scene cannot be opened, rendered, or saved.
#[derive(Debug)]
#[non_exhaustive]
pub enum Error {
    /// A file cannot be read or written.
    Io {
        /// The file.
        path: PathBuf,
        /// The error that the system reports.
        source: io::Error,
    },
    /// The scene has errors, each with a place in the text. [`fmt::Display`] shows them as the
    /// program does.
    Scene(Diagnostics),
    /// The scene has no such frame, or nothing can be rendered in it.
    Frame(FrameError),
    /// A setting has a value that it cannot have.
    Setting {
        /// Its name in the scene language.
        name: &'static str,
    },
    /// A scene that was built in memory does not hold together: what is wrong with it.
    Description(String),
    /// No picture format has this file name extension.
    Format(PathBuf),
    /// There is not enough memory for a picture of this size.
    TooLarge {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
    },
    /// The system refuses to start so many threads.
    Threads(String),
    /// The caller cancelled rendering.
    Cancelled,
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io { path, source } => write!(f, "{}: {source}", path.display()),
            Self::Scene(diagnostics) => f.write_str(diagnostics.render(false).trim_end()),
            Self::Frame(error) => write!(f, "{error}"),
            Self::Setting { name } => write!(f, "the setting `{name}` has an impossible value"),
            Self::Description(why) => f.write_str(why),
            Self::Format(path) => {
                write!(f, "{}: no picture format has this extension", path.display())
            }
            Self::TooLarge { width, height } => {
                write!(f, "there is no memory for a picture of {width} x {height} pixels")
            }
            Self::Threads(why) => write!(f, "cannot start the threads: {why}"),
            Self::Cancelled => f.write_str("rendering was cancelled"),
        }
    }
}

// Messages are whole sentences with their reasons, so there is no source to print behind them.
impl std::error::Error for Error {}

impl From<FrameError> for Error {
    fn from(error: FrameError) -> Self {
        Self::Frame(error)
    }
}
