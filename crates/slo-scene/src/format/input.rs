//! A file, read through a window of fixed size that knows its line number.

use std::io::{ErrorKind, Read};

use super::bytes::word_len;
use super::error::FileError;
use super::place::{EXCERPT_REACH, Place, count_characters, count_newlines, last_newline};

/// Bytes of the window: it fits the second-level cache of every current processor.
const WINDOW: usize = 1 << 18;

/// Bytes that stay in the window behind the reading position, for excerpts.
const HISTORY: usize = 2 * EXCERPT_REACH;

/// A place that may be needed for an error later, when the window has moved on.
#[derive(Clone, Debug, Default)]
enum Pin {
    #[default]
    Unset,
    /// Offset in the file.
    At(u64),
    Left(Box<Place>),
}

/// The file, read through a window.
///
/// Lines are not counted while reading but when the window moves (and once more for an error):
/// the parser looks at every byte only once.
pub(crate) struct Input<'r> {
    reader: &'r mut dyn Read,
    window: Box<[u8]>,
    /// Next byte to be parsed.
    position: usize,
    /// End of what was read.
    filled: usize,
    /// Whether the window holds the last byte of the file.
    at_end: bool,
    /// Offset, line and column (from 1) of the window's first byte.
    offset: u64,
    line: usize,
    column: usize,
    pins: Vec<Pin>,
}

impl<'r> Input<'r> {
    /// Nothing is read yet. `pins` is how many places can be held on to.
    pub(crate) fn new(reader: &'r mut dyn Read, pins: usize) -> Self {
        Self {
            reader,
            window: vec![0; WINDOW].into_boxed_slice(),
            position: 0,
            filled: 0,
            at_end: false,
            offset: 0,
            line: 1,
            column: 1,
            pins: vec![Pin::Unset; pins],
        }
    }

    /// What is in the window and not yet parsed; [`refill`](Self::refill) may make it longer.
    #[inline]
    pub(crate) fn rest(&self) -> &[u8] {
        &self.window[self.position..self.filled]
    }

    /// Whether [`rest`](Self::rest) goes to the end of the file.
    pub(crate) fn at_end(&self) -> bool {
        self.at_end
    }

    /// Counts `len` bytes of the rest as parsed.
    #[inline]
    pub(crate) fn advance(&mut self, len: usize) {
        self.position = (self.position + len).min(self.filled);
    }

    /// Offset in the file of the first byte of the rest.
    #[inline]
    pub(crate) fn offset(&self) -> u64 {
        self.offset + self.position as u64
    }

    /// Reads on, keeping the rest. `false`: nothing more came, because the file ends or the rest
    /// fills the window.
    ///
    /// # Errors
    /// The file can't be read.
    pub(crate) fn refill(&mut self) -> Result<bool, FileError> {
        self.forget(self.position.saturating_sub(HISTORY));
        while !self.at_end && self.filled < self.window.len() {
            match self.reader.read(&mut self.window[self.filled..]) {
                Ok(0) => self.at_end = true,
                Ok(len) => {
                    self.filled = (self.filled + len).min(self.window.len());
                    return Ok(true);
                }
                Err(e) if e.kind() == ErrorKind::Interrupted => {}
                Err(e) => return Err(self.here(0).error(format!("can't read on: {e}"), "")),
            }
        }
        Ok(false)
    }

    /// Drops the first `len` bytes of the window, settling the pins among them.
    fn forget(&mut self, len: usize) {
        let gone_until = self.offset + len as u64;
        for index in 0..self.pins.len() {
            if let Pin::At(offset) = self.pins[index]
                && offset < gone_until
            {
                self.pins[index] = Pin::Left(Box::new(self.place_of_word(offset)));
            }
        }
        let gone = &self.window[..len];
        let last_line = last_newline(gone).map_or(gone, |newline| &gone[newline + 1..]);
        let lines = count_newlines(gone);
        self.column = count_characters(last_line) + if lines > 0 { 1 } else { self.column };
        self.line += lines;
        self.offset = gone_until;
        self.window.copy_within(len..self.filled, 0);
        self.position -= len;
        self.filled -= len;
    }

    /// The place of `len` bytes at the reading position.
    pub(crate) fn here(&self, len: usize) -> Place {
        self.place(self.offset(), len)
    }

    /// As [`here`](Self::here), after more of the line was read so that the excerpt is whole.
    pub(crate) fn fault(&mut self, len: usize) -> Place {
        if self.rest().len() < len + EXCERPT_REACH {
            // An error of reading would be a second one: the first is reported.
            let _ = self.refill();
        }
        self.here(len)
    }

    /// The place of the last `len` bytes that were parsed, as far as they are still at hand.
    pub(crate) fn behind(&mut self, len: usize) -> Place {
        let offset = self.offset().saturating_sub(len as u64);
        if self.rest().len() < EXCERPT_REACH {
            // An error of reading would be a second one: the first is reported.
            let _ = self.refill();
        }
        self.place(offset.max(self.offset), len)
    }

    /// The place of `len` bytes at an offset that the window still holds.
    fn place(&self, offset: u64, len: usize) -> Place {
        let start = offset.saturating_sub(self.offset) as usize;
        Place::within(&self.window[..self.filled], self.line, self.column, start, len)
    }

    /// The place of the word that starts at an offset that the window still holds.
    fn place_of_word(&self, offset: u64) -> Place {
        let start = offset.saturating_sub(self.offset) as usize;
        let bytes = self.window[..self.filled].get(start..).unwrap_or_default();
        self.place(offset, word_len(bytes).max(1))
    }

    /// Holds on to the place at an offset, instead of what that pin held before.
    #[inline]
    pub(crate) fn pin(&mut self, pin: usize, offset: u64) {
        if let Some(slot) = self.pins.get_mut(pin) {
            *slot = Pin::At(offset);
        }
    }

    /// The place of the word that was pinned; the reading position if no word was.
    pub(crate) fn pinned(&self, pin: usize) -> Place {
        match self.pins.get(pin) {
            None | Some(Pin::Unset) => self.here(0),
            Some(Pin::At(offset)) => self.place_of_word(*offset),
            Some(Pin::Left(place)) => Place::clone(place),
        }
    }
}
