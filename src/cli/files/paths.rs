//! Checks of the paths that a map or a sheet is written to.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::cli::base::{Exit, Problem};
use slo_picture::output::check_companion;

/// Checks whether a map or a sheet can be written to a path.
///
/// # Errors
/// Something is in the way.
pub(crate) fn check_path(path: &Path) -> Result<(), Problem> {
    check_companion(path).map_err(|error| {
        let problem =
            Problem::new(Exit::CantCreate, format!("can't create `{}`: {error}", path.display()));
        match error.kind() {
            io::ErrorKind::AlreadyExists => problem.with_help("remove it, or choose another name"),
            _ => problem,
        }
    })
}

/// Refuses a path that is one of the `inputs`, which are read.
///
/// # Errors
/// The path is an input, which the message names.
pub(crate) fn check_distinct<'a>(
    path: &Path,
    inputs: impl IntoIterator<Item = &'a PathBuf>,
) -> Result<(), Problem> {
    let own = place(path);
    match inputs.into_iter().find(|input| place(input) == own) {
        Some(input) => {
            let message = format!("`{}` is an input and would be replaced", input.display());
            Err(Problem::new(Exit::Usage, message))
        }
        None => Ok(()),
    }
}

/// Returns the same path for a file however it is named, as far as its folders exist.
pub(crate) fn place(path: &Path) -> PathBuf {
    let in_folder = || {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        let folder = fs::canonicalize(folder.unwrap_or(Path::new("."))).ok()?;
        Some(folder.join(path.file_name()?))
    };
    let there = fs::canonicalize(path).ok().or_else(in_folder);
    there.or_else(|| std::path::absolute(path).ok()).unwrap_or_else(|| path.to_owned())
}
