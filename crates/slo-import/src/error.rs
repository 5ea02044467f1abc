//! Why a file can't be imported.

use std::fmt;
use std::io;
use std::path::PathBuf;

/// Why a file can't be imported.
#[derive(Debug)]
#[non_exhaustive]
pub enum ImportError {
    /// A file can't be read.
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        error: io::Error,
    },
    /// A file is damaged, or not what it seems.
    Bad {
        /// The file.
        path: PathBuf,
        /// Line, from 1, if the file is text and the place is known.
        line: Option<usize>,
        /// What is wrong.
        message: String,
    },
}

impl fmt::Display for ImportError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read { path, error } => write!(f, "can't read `{}`: {error}", path.display()),
            Self::Bad { path, line: Some(line), message } => {
                write!(f, "`{}`, line {line}: {message}", path.display())
            }
            Self::Bad { path, line: None, message } => write!(f, "`{}`: {message}", path.display()),
        }
    }
}

impl std::error::Error for ImportError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Read { error, .. } => Some(error),
            Self::Bad { .. } => None,
        }
    }
}
