//! Indices into a section that may be further down in the file.

use super::faults;
use super::section::{Pinned, Section};
use super::words::{Token, Words};
use crate::format::{FileError, quick_u32};

/// The indices of one section and what they may be.
pub(super) struct Indices {
    /// What they are indices of.
    target: Section,
    /// Where the largest one is pinned.
    pin: Pinned,
    /// How many things there are to refer to; unknown until their section was read.
    count: Option<usize>,
    /// One more than the largest index that needs no attention.
    bound: u32,
    /// How many were read.
    read: usize,
    /// Which of them is the largest, while the count is unknown.
    largest: usize,
}

impl Indices {
    /// Indices into `target`; nothing is known of it.
    pub(super) fn into_section(target: Section, pin: Pinned) -> Self {
        Self { target, pin, count: None, bound: 0, read: 0, largest: 0 }
    }

    /// Says how many things there are to refer to.
    pub(super) fn set_count(&mut self, count: usize) {
        self.count = Some(count);
        if self.read == 0 {
            self.bound = count.try_into().unwrap_or(u32::MAX);
        }
    }

    /// The next index of a section; `None` in front of the closing brace.
    ///
    /// # Errors
    /// There is something else, or the index is out of range.
    #[inline]
    pub(super) fn next(
        &mut self,
        words: &mut Words<'_>,
        section: Section,
    ) -> Result<Option<u32>, FileError> {
        if let Some(index) = words.quick(|bytes| quick_u32(bytes).filter(|q| q.0 < self.bound)) {
            self.read += 1;
            return Ok(Some(index));
        }
        self.thorough_next(words, section)
    }

    /// The next index, whatever is in front of it and however large it is.
    #[cold]
    fn thorough_next(
        &mut self,
        words: &mut Words<'_>,
        section: Section,
    ) -> Result<Option<u32>, FileError> {
        let token = words.peek()?;
        let Token::Word(len) = token else {
            if token == Token::Close {
                return Ok(None);
            }
            return Err(faults::no_number(words, section, token));
        };
        let Some(index) = parse_index(words.bytes(token)) else {
            return Err(faults::bad_index(words, section, self.target, token));
        };
        if index >= self.bound {
            self.past_bound(words, section, index, token)?;
        }
        words.input.advance(len);
        self.read += 1;
        Ok(Some(index))
    }

    /// Refuses an index if the count is known; otherwise remembers its place.
    fn past_bound(
        &mut self,
        words: &mut Words<'_>,
        section: Section,
        index: u32,
        token: Token,
    ) -> Result<(), FileError> {
        if let Some(count) = self.count {
            let place = words.input.fault(token.len());
            return Err(faults::out_of_range(place, section, self.read, index, self.target, count));
        }
        self.bound = index + 1;
        self.largest = self.read;
        words.input.pin(self.pin as usize, words.input.offset());
        Ok(())
    }

    /// Refuses indices out of range that were read before the count was known.
    pub(super) fn check(&self, words: &Words<'_>, section: Section) -> Result<(), FileError> {
        let count = self.count.unwrap_or(0);
        if self.bound as usize <= count {
            return Ok(());
        }
        let place = words.input.pinned(self.pin as usize);
        let index = self.bound - 1;
        Err(faults::out_of_range(place, section, self.largest, index, self.target, count))
    }
}

/// A whole number in decimal digits, below `u32::MAX`.
fn parse_index(word: &[u8]) -> Option<u32> {
    let digits = word.iter().all(u8::is_ascii_digit);
    let text = str::from_utf8(word).ok().filter(|_| digits)?;
    text.parse().ok().filter(|&index| index < u32::MAX)
}
