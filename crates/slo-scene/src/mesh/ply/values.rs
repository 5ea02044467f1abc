//! Numbers of a `.ply` file, in any encoding.

use super::header::{Encoding, Scalar};
use crate::format::{FileError, Input, blank_len, parse_word, quick_f64, word_len};
use crate::mesh::numbers::is_not_finite;

/// What is being read, for messages.
#[derive(Clone, Copy, Debug)]
pub(super) struct Context<'h> {
    pub(super) element: &'h str,
    pub(super) item: u64,
    pub(super) property: &'h str,
}

/// The body of a file as a sequence of numbers.
pub(super) struct Values<'r> {
    input: Input<'r>,
    encoding: Encoding,
    /// Bytes of the number that was read last.
    last_len: usize,
}

impl<'r> Values<'r> {
    /// Numbers from the reading position on.
    pub(super) fn new(input: Input<'r>, encoding: Encoding) -> Self {
        Self { input, encoding, last_len: 0 }
    }

    /// The next number, which is finite. Every type fits f64.
    ///
    /// # Errors
    /// The file ends, or the next word is something else.
    #[inline]
    pub(super) fn next(&mut self, scalar: Scalar, context: Context<'_>) -> Result<f64, FileError> {
        let value = self.next_or_nan(scalar, context)?;
        if value.is_finite() { Ok(value) } else { Err(self.fault(context, "is not finite")) }
    }

    /// The next number as f64, which is NaN if the file says NaN, infinity or too large a number.
    ///
    /// # Errors
    /// The file ends, or the next word is something else.
    #[inline]
    pub(super) fn next_or_nan(
        &mut self,
        scalar: Scalar,
        context: Context<'_>,
    ) -> Result<f64, FileError> {
        let value = match self.encoding {
            Encoding::Ascii => self.next_ascii(context)?,
            _ => self.next_binary(scalar, context)?,
        };
        Ok(if value.is_finite() { value } else { f64::NAN })
    }

    /// Passes over a number, which need not be finite, nor a number at all if the file is text.
    ///
    /// # Errors
    /// The file ends.
    pub(super) fn skip(&mut self, scalar: Scalar, context: Context<'_>) -> Result<(), FileError> {
        if self.encoding == Encoding::Ascii {
            let len = self.next_word(context)?;
            self.input.advance(len);
            return Ok(());
        }
        self.next_binary(scalar, context).map(|_| ())
    }

    /// The next number in bytes.
    #[inline]
    fn next_binary(&mut self, scalar: Scalar, context: Context<'_>) -> Result<f64, FileError> {
        let len = scalar.size();
        while self.input.rest().len() < len {
            if !self.input.refill()? {
                return Err(self.cut(context));
            }
        }
        let mut bytes = [0; 8];
        bytes[..len].copy_from_slice(&self.input.rest()[..len]);
        if self.encoding == Encoding::BigEndian {
            bytes[..len].reverse();
        }
        self.input.advance(len);
        Ok(number(scalar, bytes))
    }

    /// The next number in text, which may be infinite or NaN.
    #[inline]
    fn next_ascii(&mut self, context: Context<'_>) -> Result<f64, FileError> {
        let blank = blank_len(self.input.rest());
        if let Some((value, len)) = quick_f64(&self.input.rest()[blank..]) {
            self.input.advance(blank + len);
            self.last_len = len;
            return Ok(value);
        }
        let len = self.next_word(context)?;
        let word = &self.input.rest()[..len];
        let parsed = parse_word(word).or_else(|fault| {
            if is_not_finite(&String::from_utf8_lossy(word)) { Ok(f64::NAN) } else { Err(fault) }
        });
        self.input.advance(len);
        self.last_len = len;
        parsed.map_err(|fault| {
            let error = self.fault(context, "is not a number");
            FileError {
                label: fault.message,
                help: fault.help.map(String::into_boxed_str),
                ..error
            }
        })
    }

    /// Bytes of the next word, 1 or more, which then starts the rest of the input.
    #[cold]
    fn next_word(&mut self, context: Context<'_>) -> Result<usize, FileError> {
        loop {
            let blank = blank_len(self.input.rest());
            self.input.advance(blank);
            let rest = self.input.rest();
            let len = word_len(rest);
            if len > 0 && (len < rest.len() || self.input.at_end()) {
                return Ok(len);
            }
            // A brace: no word, and no number either.
            if len == 0 && !rest.is_empty() {
                return Ok(1);
            }
            if !self.input.refill()? && (self.input.rest().is_empty() || !self.input.at_end()) {
                return Err(self.cut(context));
            }
        }
    }

    /// An error about the number that was read last: `what` is wrong with it.
    pub(super) fn fault(&mut self, context: Context<'_>, what: &str) -> FileError {
        let Context { element, item, property } = context;
        let message = format!("`{property}` of {element} {item} {what}");
        match self.encoding {
            Encoding::Ascii => self.input.behind(self.last_len).error(message, ""),
            _ => FileError::whole_file(message),
        }
    }

    /// A file that ends too early.
    fn cut(&mut self, context: Context<'_>) -> FileError {
        let Context { element, item, property } = context;
        let message = format!("the file ends before `{property}` of {element} {item}");
        match self.encoding {
            Encoding::Ascii => self.input.fault(0).error(message, ""),
            _ => FileError::whole_file(message),
        }
    }
}

/// A little-endian number of that type.
fn number(scalar: Scalar, bytes: [u8; 8]) -> f64 {
    let bits = u64::from_le_bytes(bytes);
    match scalar {
        Scalar::I8 => f64::from(bits as u8 as i8),
        Scalar::U8 => f64::from(bits as u8),
        Scalar::I16 => f64::from(bits as u16 as i16),
        Scalar::U16 => f64::from(bits as u16),
        Scalar::I32 => f64::from(bits as u32 as i32),
        Scalar::U32 => f64::from(bits as u32),
        Scalar::F32 => f64::from(f32::from_bits(bits as u32)),
        Scalar::F64 => f64::from_bits(bits),
    }
}
