//! The lines of an `.obj` file that make a mesh, checked one by one.

use std::fmt::Write;
use std::io::{self, BufRead, BufReader, Read};

use super::index::{Corner, Forward};
use super::statement::{self, Statement};
use crate::format::{FileError, Place};

/// Bytes that a line may have.
const MAX_LINE: u64 = 1 << 24;

/// What a triangle has beyond its positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Parts {
    /// All of its corners have uvs.
    pub(super) uvs: bool,
    /// All of its corners have normals.
    pub(super) normals: bool,
}

/// Vertices, uvs, normals and faces of a file, in clean lines; everything else is left out.
///
/// The first fault ends the reading with an error and is kept in here.
pub(super) struct Lines<'r> {
    reader: BufReader<&'r mut dyn Read>,
    /// The line as it is in the file, with those that a backslash joins to it.
    raw: Vec<u8>,
    /// Number of the first line in `raw`.
    line: usize,
    /// Number of the line after `raw`.
    next_line: usize,
    clean: String,
    /// Bytes of `clean` that were read.
    consumed: usize,
    /// How many vertices, uvs and normals there were.
    counts: [u64; 3],
    forward: [Option<Forward>; 3],
    parts: Vec<Parts>,
    fault: Option<FileError>,
}

impl<'r> Lines<'r> {
    /// Nothing is read yet.
    pub(super) fn new(reader: &'r mut dyn Read) -> Self {
        Self {
            reader: BufReader::with_capacity(1 << 18, reader),
            raw: Vec::new(),
            line: 1,
            next_line: 1,
            clean: String::new(),
            consumed: 0,
            counts: [0; 3],
            forward: [None, None, None],
            parts: Vec::new(),
            fault: None,
        }
    }

    /// The fault that ended the reading.
    pub(super) fn take_fault(&mut self) -> Option<FileError> {
        self.fault.take()
    }

    /// What each triangle has, in the order of the file.
    pub(super) fn into_parts(self) -> Vec<Parts> {
        self.parts
    }

    /// An error in the line that was read last.
    pub(super) fn here(&self, message: String) -> FileError {
        self.place(0, self.raw.trim_ascii_end().len()).error(message, "")
    }

    /// The place of bytes of the line that was read last.
    fn place(&self, start: usize, len: usize) -> Place {
        Place::within(&self.raw, self.line, 1, start, len)
    }

    /// Puts the next line that matters into `clean`, and nothing at the end of the file.
    fn advance(&mut self) -> Result<(), FileError> {
        self.clean.clear();
        self.consumed = 0;
        while self.clean.is_empty() {
            self.line = self.next_line;
            self.raw.clear();
            if !self.read_line()? {
                return self.forward.iter().flatten().try_for_each(|f| f.check(self.counts));
            }
            while self.is_continued() && self.read_line()? {}
            self.clean_line()?;
        }
        Ok(())
    }

    /// Adds a line of the file to `raw`; `false` at the end of the file.
    fn read_line(&mut self) -> Result<bool, FileError> {
        let before = self.raw.len();
        let room = MAX_LINE.saturating_sub(before as u64);
        let read = self.reader.by_ref().take(room).read_until(b'\n', &mut self.raw);
        read.map_err(|e| self.place(before, 0).error(format!("can't read on: {e}"), ""))?;
        if self.raw.len() as u64 >= MAX_LINE {
            let message = format!("a line of more than {MAX_LINE} bytes");
            return Err(self.place(0, 1).error(message, "starts here"));
        }
        self.next_line += 1;
        Ok(self.raw.len() > before)
    }

    /// Whether a backslash joins the next line; it becomes a space.
    fn is_continued(&mut self) -> bool {
        let end = self.raw.trim_ascii_end().len();
        let continued = self.raw[..end].ends_with(b"\\") && !self.raw.contains(&b'#');
        if continued {
            self.raw[end - 1] = b' ';
        }
        continued
    }

    /// Checks `raw` and puts it into `clean` if it matters.
    fn clean_line(&mut self) -> Result<(), FileError> {
        let comment = self.raw.iter().position(|&b| b == b'#').unwrap_or(self.raw.len());
        match statement::parse(&self.raw[..comment], self.counts) {
            Ok(None) => {}
            Ok(Some(Statement::Point(kind, line))) => {
                self.counts[kind] += 1;
                self.clean = line;
            }
            Ok(Some(Statement::Face(corners))) => self.face(&corners),
            Err(fault) => {
                let error = self.place(fault.start, fault.len).error(fault.message, "");
                return Err(FileError { help: fault.help.map(String::into_boxed_str), ..error });
            }
        }
        if !self.clean.is_empty() {
            self.clean.push('\n');
        }
        if self.counts.iter().any(|&count| count > u64::from(u32::MAX)) {
            return Err(self.here(format!("more vertices, uvs or normals than {}", u32::MAX)));
        }
        Ok(())
    }

    /// Writes a face, without uvs or normals that only some of its corners have.
    fn face(&mut self, corners: &[(Corner, usize, usize)]) {
        let has = |kind: usize| corners.iter().all(|(corner, ..)| corner[kind] > 0);
        let parts = Parts { uvs: has(1), normals: has(2) };
        self.parts.extend(std::iter::repeat_n(parts, corners.len() - 2));
        self.clean.push('f');
        for &(corner, start, len) in corners {
            self.note_forward(corner, start, len);
            let [v, vt, vn] = corner;
            // Writing to a String does not fail.
            let _ = match (parts.uvs, parts.normals) {
                (false, false) => write!(self.clean, " {v}"),
                (true, false) => write!(self.clean, " {v}/{vt}"),
                (false, true) => write!(self.clean, " {v}//{vn}"),
                (true, true) => write!(self.clean, " {v}/{vt}/{vn}"),
            };
        }
    }

    /// Remembers indices of what is not there yet.
    fn note_forward(&mut self, corner: Corner, start: usize, len: usize) {
        for (kind, &index) in corner.iter().enumerate() {
            let known = self.forward[kind].as_ref().map_or(0, |forward| forward.index);
            if index > self.counts[kind].max(known) {
                let place = self.place(start, len);
                self.forward[kind] = Some(Forward { index, kind, place });
            }
        }
    }
}

impl Read for Lines<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let len = self.fill_buf()?.read(buffer)?;
        self.consume(len);
        Ok(len)
    }
}

impl BufRead for Lines<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.consumed >= self.clean.len()
            && let Err(fault) = self.advance()
        {
            self.fault = Some(fault);
            return Err(io::Error::other("a fault in the file"));
        }
        Ok(&self.clean.as_bytes()[self.consumed..])
    }

    fn consume(&mut self, len: usize) {
        self.consumed += len;
    }
}
