//! The words of a text file, with their lines.

use std::str::{FromStr, SplitWhitespace};

use glam::DVec3;

use crate::error::ImportError;
use crate::files::Source;

/// Words that white space separates. `#` and `%` begin comments.
pub(crate) struct Words<'a> {
    pub(crate) source: &'a Source,
    lines: std::str::Lines<'a>,
    words: SplitWhitespace<'a>,
    /// Number of the current line, from 1.
    line: usize,
    ahead: Option<&'a str>,
}

impl<'a> Words<'a> {
    /// The words of a file, whose text this is.
    pub(crate) fn new(source: &'a Source, text: &'a str) -> Self {
        let words = "".split_whitespace();
        Self { source, lines: text.lines(), words, line: 0, ahead: None }
    }

    /// The next word; `None` at the end.
    pub(crate) fn next(&mut self) -> Option<&'a str> {
        if let Some(word) = self.ahead.take() {
            return Some(word);
        }
        loop {
            if let Some(word) = self.words.next() {
                return Some(word);
            }
            let line = self.lines.next()?;
            self.line += 1;
            self.words = line.split(['#', '%']).next().unwrap_or_default().split_whitespace();
        }
    }

    /// The next word, which is not taken yet.
    pub(crate) fn peek(&mut self) -> Option<&'a str> {
        self.ahead = self.next();
        self.ahead
    }

    /// Whether a number follows.
    pub(crate) fn is_number(&mut self) -> bool {
        self.peek().is_some_and(|word| f64::from_str(word).is_ok())
    }

    /// An error at the current line.
    pub(crate) fn bad<T>(&self, message: impl Into<String>) -> Result<T, ImportError> {
        Err(self.source.bad_line(self.line, message))
    }

    /// A name: any word.
    pub(crate) fn name(&mut self, of: &str) -> Result<&'a str, ImportError> {
        match self.next() {
            Some(word) if word != "{" && word != "}" => Ok(word),
            Some(word) => self.bad(format!("expected {of} instead of `{word}`")),
            None => self.bad(format!("{of} is missing at the end")),
        }
    }

    /// Any word.
    pub(crate) fn any(&mut self, of: &str) -> Result<&'a str, ImportError> {
        match self.next() {
            Some(word) => Ok(word),
            None => self.bad(format!("{of} is missing at the end")),
        }
    }

    /// A finite number.
    pub(crate) fn number(&mut self) -> Result<f64, ImportError> {
        let Some(word) = self.next() else { return self.bad("a number is missing at the end") };
        match f64::from_str(word) {
            Ok(number) if number.is_finite() => Ok(number),
            _ => self.bad(format!("expected a number instead of `{}`", shortened(word))),
        }
    }

    /// Three numbers.
    pub(crate) fn vector(&mut self) -> Result<DVec3, ImportError> {
        Ok(DVec3::new(self.number()?, self.number()?, self.number()?))
    }

    /// A whole number in this range.
    pub(crate) fn count(&mut self, least: usize, most: usize) -> Result<usize, ImportError> {
        let number = self.number()?;
        if number.fract() != 0.0 || number < least as f64 || number > most as f64 {
            return self.bad(format!(
                "expected a whole number from {least} to {most} instead of {number}"
            ));
        }
        Ok(number as usize)
    }

    /// This word.
    pub(crate) fn word(&mut self, expected: &str) -> Result<(), ImportError> {
        match self.next() {
            Some(word) if word == expected => Ok(()),
            Some(word) => {
                self.bad(format!("expected `{expected}` instead of `{}`", shortened(word)))
            }
            None => self.bad(format!("`{expected}` is missing at the end")),
        }
    }

    /// Takes this word if it is the next one.
    pub(crate) fn takes(&mut self, word: &str) -> bool {
        let is_next = self.peek() == Some(word);
        if is_next {
            self.ahead = None;
        }
        is_next
    }
}

/// A word that a message shows.
pub(crate) fn shortened(word: &str) -> String {
    word.chars().take(40).collect()
}
