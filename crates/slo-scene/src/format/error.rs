//! What is wrong with a file that is not a scene text: a mesh or an image.

use std::fmt;

/// Why a mesh or a texture can't be used, with the place of the fault.
///
/// The file itself may be gigabytes long, so the error carries the part of the line that is
/// worth showing. [`Display`](fmt::Display) gives one line without the excerpt.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FileError {
    /// Line from 1; 0 if the error has no place (binary files, missing sections).
    pub line: usize,
    /// Column from 1, in characters of the whole line; 0 if the error has no place.
    pub column: usize,
    /// The line, or the part of a long line around the column; empty if there is no place.
    pub line_text: String,
    /// Byte of `line_text` at which the fault starts: a character boundary, at most its length.
    pub span_start: usize,
    /// Length of the fault in `line_text`, in bytes; may be 0 at the end of the file.
    pub span_len: usize,
    /// What is wrong, in one line.
    pub message: String,
    /// Words beside the underline; may be empty.
    pub label: String,
    /// What to write instead. Not a `String`: the error is returned by value from inner loops.
    pub help: Option<Box<str>>,
}

impl FileError {
    /// An error about the file as a whole.
    pub fn whole_file(message: impl Into<String>) -> Self {
        Self { message: message.into(), ..Self::default() }
    }

    /// The same error with advice.
    pub fn with_help(self, help: impl Into<Box<str>>) -> Self {
        Self { help: Some(help.into()), ..self }
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.line > 0 {
            write!(f, "{}:{}: ", self.line, self.column)?;
        }
        f.write_str(&self.message)
    }
}

impl std::error::Error for FileError {}
