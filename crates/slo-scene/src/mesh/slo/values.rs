//! Numbers of a section, up to its closing brace.

use super::faults;
use super::section::Section;
use super::words::{Token, Words};
use crate::format::{FileError, parse_word, quick_f64};

/// The next number of a section; `None` in front of the closing brace.
///
/// # Errors
/// The next word is something else.
#[inline]
pub(super) fn next_f64(words: &mut Words<'_>, section: Section) -> Result<Option<f64>, FileError> {
    match words.quick(quick_f64) {
        Some(value) => Ok(Some(value)),
        None => thorough_f64(words, section),
    }
}

/// As [`next_f64`], rounded to f32.
///
/// # Errors
/// There is something else, or the number is too large for f32.
#[inline]
pub(super) fn next_f32(words: &mut Words<'_>, section: Section) -> Result<Option<f32>, FileError> {
    let Some(value) = next_f64(words, section)? else { return Ok(None) };
    if (value as f32).is_finite() {
        return Ok(Some(value as f32));
    }
    Err(faults::too_large_for_f32(words, section, value))
}

/// The next number of a section, whatever precedes it.
#[cold]
fn thorough_f64(words: &mut Words<'_>, section: Section) -> Result<Option<f64>, FileError> {
    let token = words.peek()?;
    match token {
        Token::Close => Ok(None),
        Token::Open | Token::End => Err(faults::no_number(words, section, token)),
        Token::Word(len) => match parse_word(words.bytes(token)) {
            Ok(value) => {
                words.input.advance(len);
                Ok(Some(value))
            }
            Err(fault) => Err(faults::bad_number(words, section, token, fault)),
        },
    }
}
