//! The lines of an `.obj` file; lines that a backslash joins are one.

use std::io::{BufRead, BufReader, Read};

use super::statement::Fault;
use crate::format::{FileError, Place};

/// Bytes that a line may have.
const MAX_LINE: usize = 1 << 24;

/// The lines of a file, one at a time. They end with LF, CR LF or CR.
pub(super) struct Lines<'r> {
    reader: BufReader<&'r mut dyn Read>,
    /// The line as it is in the file, with the lines that a backslash joins to it. Each ends with LF.
    raw: Vec<u8>,
    /// Bytes of `raw` in front of its comment.
    len: usize,
    /// Number of the first line in `raw`.
    line: usize,
    /// Number of the line after `raw`.
    next_line: usize,
    /// Whether the last line ended with CR: an LF that follows belongs to it.
    after_cr: bool,
}

impl<'r> Lines<'r> {
    /// Nothing is read yet.
    pub(super) fn new(reader: &'r mut dyn Read) -> Self {
        Self {
            reader: BufReader::with_capacity(1 << 18, reader),
            raw: Vec::new(),
            len: 0,
            line: 1,
            next_line: 1,
            after_cr: false,
        }
    }

    /// Reads the next line; `false` at the end of the file.
    ///
    /// Takes a time proportional to its length, however many lines are joined.
    ///
    /// # Errors
    /// The file can't be read, or the line is too long.
    pub(super) fn advance(&mut self) -> Result<bool, FileError> {
        self.raw.clear();
        self.line = self.next_line;
        loop {
            let start = self.raw.len();
            let is_last = !self.read_line()?;
            let comment = comment_start(&self.raw[start..]);
            self.len = comment.map_or(self.raw.len(), |comment| start + comment);
            if is_last || comment.is_some() || !self.is_continued(start) {
                return Ok(!self.raw.is_empty());
            }
        }
    }

    /// The line that was read last, without its comment.
    pub(super) fn text(&self) -> &[u8] {
        &self.raw[..self.len]
    }

    /// The number of the line that was read last, from 1.
    pub(super) fn number(&self) -> usize {
        self.line
    }

    /// The place of bytes of the line that was read last.
    pub(super) fn place(&self, start: usize, len: usize) -> Place {
        Place::within(&self.raw, self.line, 1, start, len)
    }

    /// The error about bytes of the line that was read last.
    pub(super) fn error(&self, fault: Fault) -> FileError {
        let error = self.place(fault.start, fault.len).error(fault.message, "");
        FileError { help: fault.help.map(String::into_boxed_str), ..error }
    }

    /// Adds a line of the file to `raw`; `false` at the end of the file.
    fn read_line(&mut self) -> Result<bool, FileError> {
        loop {
            let bytes = match self.reader.fill_buf() {
                Ok(bytes) => bytes,
                Err(e) if e.kind() == std::io::ErrorKind::Interrupted => continue,
                Err(e) => {
                    let place = self.place(self.raw.len(), 0);
                    return Err(place.error(format!("can't read on: {e}"), ""));
                }
            };
            if std::mem::take(&mut self.after_cr) && bytes.first() == Some(&b'\n') {
                self.reader.consume(1);
                continue;
            }
            if bytes.is_empty() {
                return Ok(false);
            }
            let end = bytes.iter().position(|b| matches!(b, b'\n' | b'\r'));
            let part = &bytes[..end.unwrap_or(bytes.len())];
            self.raw.extend_from_slice(part);
            self.after_cr = end.is_some_and(|end| bytes[end] == b'\r');
            let consumed = part.len() + usize::from(end.is_some());
            self.reader.consume(consumed);
            if self.raw.len() >= MAX_LINE {
                let message = format!("a line of more than {MAX_LINE} bytes");
                return Err(self.place(0, 1).error(message, "starts here"));
            }
            if end.is_some() {
                self.raw.push(b'\n');
                self.next_line += 1;
                return Ok(true);
            }
        }
    }

    /// Whether a backslash ends the line at `start` of `raw`, so that the next one belongs to it.
    /// The backslash becomes a space.
    fn is_continued(&mut self, start: usize) -> bool {
        let end = start + self.raw[start..].trim_ascii_end().len();
        let continued = self.raw[start..end].ends_with(b"\\");
        if continued {
            self.raw[end - 1] = b' ';
        }
        continued
    }
}

/// Where the comment of a line begins.
///
/// The `#` of `-1.#IND00` is part of a number: older Windows programs write NaN and infinity so.
fn comment_start(line: &[u8]) -> Option<usize> {
    let is_in_number = |at: usize| {
        line.get(at + 1).is_some_and(u8::is_ascii_uppercase)
            && line[..at].ends_with(b"1.")
            && !line[..at - 2].last().is_some_and(u8::is_ascii_alphanumeric)
    };
    let hashes = line.iter().enumerate().filter(|(_, b)| **b == b'#').map(|(at, _)| at);
    hashes.into_iter().find(|&at| !is_in_number(at))
}
