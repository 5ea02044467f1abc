//! The file that is imported, and the files that it names.

use std::fs;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use crate::error::ImportError;

/// Most bytes of a file.
const MOST_BYTES: u64 = 4 << 30;

/// The file that is imported.
pub(crate) struct Source {
    path: PathBuf,
    /// The folder that files must not leave; `None` if they may.
    folder: Option<PathBuf>,
    pub(crate) bytes: Vec<u8>,
}

impl Source {
    /// Opens the file that is imported.
    pub(crate) fn open(path: &Path, allow_outside: bool) -> Result<Self, ImportError> {
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        Self::read(path, (!allow_outside).then_some(folder))
    }

    fn read(path: &Path, folder: Option<PathBuf>) -> Result<Self, ImportError> {
        let bytes = read(path).map_err(|error| ImportError::Read { path: path.into(), error })?;
        Ok(Self { path: path.into(), folder, bytes })
    }

    /// Name of the file.
    pub(crate) fn name(&self) -> String {
        self.path.file_name().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// Name of the file without its ending.
    pub(crate) fn stem(&self) -> String {
        self.path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// Ending of the name, in lower case.
    pub(crate) fn ending(&self) -> String {
        self.path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
    }

    /// The file as text. Bytes that are no UTF-8 are replaced.
    pub(crate) fn text(&self) -> String {
        String::from_utf8_lossy(&self.bytes).into_owned()
    }

    /// An error of the whole file.
    pub(crate) fn bad(&self, message: impl Into<String>) -> ImportError {
        ImportError::Bad { path: self.path.clone(), line: None, message: message.into() }
    }

    /// An error of a line, from 1.
    pub(crate) fn bad_line(&self, line: usize, message: impl Into<String>) -> ImportError {
        ImportError::Bad { path: self.path.clone(), line: Some(line), message: message.into() }
    }

    /// Opens a file that this one names.
    pub(crate) fn beside(&self, name: &str) -> Result<Self, ImportError> {
        // Backslashes are common in files that were written on Windows.
        let name = name.replace('\\', "/");
        let path = self.path.parent().unwrap_or(Path::new("")).join(&name);
        if self.folder.as_ref().is_some_and(|folder| !is_below(folder, &path)) {
            let message =
                format!("`{name}` lies outside of the folder; `--allow-outside` reads it");
            return Err(self.bad(message));
        }
        Self::read(&path, self.folder.clone())
    }
}

/// Whether a path lies in a folder, after links were followed. What does not exist can't be read either.
fn is_below(folder: &Path, path: &Path) -> bool {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let (Ok(folder), Ok(path)) = (folder.canonicalize(), path.canonicalize()) else { return true };
    path.starts_with(folder)
}

fn read(path: &Path) -> io::Result<Vec<u8>> {
    // Opening a pipe would wait for somebody who writes.
    let metadata = fs::metadata(path)?;
    if !metadata.is_file() {
        return Err(io::Error::other("it is not a regular file"));
    }
    if metadata.len() > MOST_BYTES {
        return Err(io::Error::other("it is larger than 4 GiB"));
    }
    let mut bytes = Vec::new();
    fs::File::open(path)?.take(MOST_BYTES).read_to_end(&mut bytes)?;
    Ok(bytes)
}
