//! Pictures that commands read.

use std::path::Path;

use crate::cli::base::{Exit, Problem};
use slo_picture::output::{Raster, ReadError};

/// Reason for refusing a file that was made from pictures.
pub(crate) const NO_PICTURE: &str = "a map or a sheet of slo-rt, not a picture";

/// Reads a picture.
pub(crate) fn read(path: &Path) -> Result<Raster, Problem> {
    Raster::read(path).map_err(|error| {
        Problem::new(unreadable(&error), format!("can't read `{}`: {error}", path.display()))
    })
}

/// Returns the exit code for a picture that can't be read.
pub(crate) fn unreadable(error: &ReadError) -> Exit {
    match error {
        ReadError::Io(_) => Exit::NoInput,
        ReadError::Bad(_) => Exit::BadInput,
        ReadError::TooLarge { .. } => Exit::Failed,
    }
}
