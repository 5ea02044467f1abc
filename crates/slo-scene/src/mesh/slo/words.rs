//! Words, braces and comments of a `.slo` file.

use std::io::Read;

use super::section::Pinned;
use crate::format::{FileError, Input, blank_len, is_space, word_len};

/// What comes next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Token {
    /// `{`
    Open,
    /// `}`
    Close,
    /// Anything else, with its length in bytes.
    Word(usize),
    /// The end of the file.
    End,
}

impl Token {
    /// Bytes that it takes.
    pub(super) fn len(self) -> usize {
        match self {
            Self::Open | Self::Close => 1,
            Self::Word(len) => len,
            Self::End => 0,
        }
    }
}

/// A file as a sequence of tokens.
pub(super) struct Words<'r> {
    pub(super) input: Input<'r>,
}

impl<'r> Words<'r> {
    /// The words of a file; a byte order mark in front of them is skipped.
    ///
    /// # Errors
    /// The file can't be read.
    pub(super) fn new(reader: &'r mut dyn Read) -> Result<Self, FileError> {
        let mut input = Input::new(reader, Pinned::COUNT);
        while input.rest().len() < 3 && input.refill()? {}
        if input.rest().starts_with(b"\xEF\xBB\xBF") {
            input.advance(3);
        }
        Ok(Self { input })
    }

    /// The next token, which then starts the rest of the input and is not consumed.
    ///
    /// # Errors
    /// The file can't be read, a comment has no end, or a word does not fit the window.
    pub(super) fn peek(&mut self) -> Result<Token, FileError> {
        self.skip_blank()?;
        loop {
            let rest = self.input.rest();
            match rest.first() {
                None => return Ok(Token::End),
                Some(b'{') => return Ok(Token::Open),
                Some(b'}') => return Ok(Token::Close),
                Some(_) => {}
            }
            let len = word_len(rest);
            if len < rest.len() || self.input.at_end() {
                return Ok(Token::Word(len));
            }
            if !self.input.refill()? && !self.input.at_end() {
                let place = self.input.here(1);
                return Err(place.error(format!("a word of more than {len} bytes"), "starts here"));
            }
        }
    }

    /// The bytes of the next token.
    pub(super) fn bytes(&self, token: Token) -> &[u8] {
        self.input.rest().get(..token.len()).unwrap_or_default()
    }

    /// Skips white space and comments. Three bytes show what comes next: comments begin with two,
    /// and the longest white space has three.
    fn skip_blank(&mut self) -> Result<(), FileError> {
        loop {
            let blank = blank_len(self.input.rest());
            self.input.advance(blank);
            let rest = self.input.rest();
            if rest.starts_with(b"#") {
                self.skip_line()?;
            } else if rest.starts_with(b"/*") {
                self.skip_comment()?;
            } else if rest.len() > 2 || !self.input.refill()? {
                return Ok(());
            }
        }
    }

    /// Skips what is left of the line.
    fn skip_line(&mut self) -> Result<(), FileError> {
        loop {
            let rest = self.input.rest();
            if let Some(newline) = rest.iter().position(|&b| b == b'\n') {
                self.input.advance(newline);
                return Ok(());
            }
            let len = rest.len();
            self.input.advance(len);
            if !self.input.refill()? {
                return Ok(());
            }
        }
    }

    /// Skips `/* ... */`.
    fn skip_comment(&mut self) -> Result<(), FileError> {
        self.input.pin(Pinned::Comment as usize, self.input.offset());
        self.input.advance(2);
        loop {
            let rest = self.input.rest();
            if let Some(end) = rest.windows(2).position(|pair| pair == b"*/") {
                self.input.advance(end + 2);
                return Ok(());
            }
            // The last byte stays: it may be the asterisk of the end.
            let len = rest.len().saturating_sub(1);
            self.input.advance(len);
            if !self.input.refill()? {
                let place = self.input.pinned(Pinned::Comment as usize);
                let error = place.error("this comment has no end", "starts here");
                return Err(error.with_help("write `*/` where it ends; comments do not nest"));
            }
        }
    }

    /// A number by the quick way: white space, then a word that `parse` takes. `None` says only
    /// that the thorough way must look.
    #[inline]
    pub(super) fn quick<T>(
        &mut self,
        parse: impl FnOnce(&[u8]) -> Option<(T, usize)>,
    ) -> Option<T> {
        let rest = self.input.rest();
        let blank = rest.iter().position(|&b| !is_space(b))?;
        let (value, len) = parse(&rest[blank..])?;
        self.input.advance(blank + len);
        Some(value)
    }
}
