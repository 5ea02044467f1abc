//! Whether a file can hold as many pixels as its header says.
//!
//! A header of a few bytes can claim any size. Before memory is allocated, the claim is compared with
//! the length of the file.

use std::fmt;
use std::io;

use slo_scene::memory;

/// Pixels that any picture may have: 8K UHD fits.
const MOST_PIXELS: u64 = 1 << 25;
/// Pixels for each byte of a larger file: rendered pictures have far fewer.
const MOST_PIXELS_PER_BYTE: u64 = 32;

/// Why a picture can't be read.
#[derive(Debug)]
pub enum ReadError {
    /// What the system says.
    Io(io::Error),
    /// What is wrong with the file.
    Bad(String),
    /// There is not enough memory.
    TooLarge {
        /// Columns and rows of the picture.
        size: [u64; 2],
        /// What it needs, and what there is.
        needs: String,
    },
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Io(error) => write!(f, "{error}"),
            Self::Bad(why) => f.write_str(why),
            Self::TooLarge { size: [width, height], needs } => {
                write!(f, "not enough memory: its {width}x{height} pixels need {needs}")
            }
        }
    }
}

impl std::error::Error for ReadError {}

impl From<io::Error> for ReadError {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

impl ReadError {
    pub(super) fn bad(why: impl Into<String>) -> Self {
        Self::Bad(why.into())
    }
}

/// Black pixels of a picture of so many columns and rows in a file of `file_bytes`.
///
/// # Errors
/// The file is too short for such a picture; there is not enough memory.
pub(super) fn pixels(size: [u64; 2], file_bytes: u64) -> Result<Vec<[f32; 3]>, ReadError> {
    let [width, height] = size;
    let count = width.saturating_mul(height);
    if count > MOST_PIXELS.max(file_bytes.saturating_mul(MOST_PIXELS_PER_BYTE)) {
        return Err(ReadError::Bad(format!(
            "its header claims {width}x{height} pixels, too many for a file of {}: at most 33.5 \
             million, or {MOST_PIXELS_PER_BYTE} for each byte",
            bytes(file_bytes)
        )));
    }
    let needed = count.saturating_mul(12);
    memory::check(needed)
        .map_err(|refusal| ReadError::TooLarge { size, needs: refusal.to_string() })?;
    let mut pixels = Vec::new();
    let has_room = usize::try_from(count).is_ok_and(|len| pixels.try_reserve_exact(len).is_ok());
    if !has_room {
        let needs = format!("{:.1} GB", needed as f64 / 1e9);
        return Err(ReadError::TooLarge { size, needs });
    }
    pixels.resize(count as usize, [0.0; 3]);
    Ok(pixels)
}

pub(super) fn bytes(bytes: u64) -> String {
    match bytes {
        1 => "1 byte".into(),
        ..10_000 => format!("{bytes} bytes"),
        _ => format!("{:.1} MB", bytes as f64 / 1e6),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_claim_is_compared_with_the_file() {
        let check = |size, file_bytes| pixels(size, file_bytes).map(|pixels| pixels.len());
        assert_eq!(check([5, 3], 100).unwrap(), 15);
        let message = check([60_000, 60_000], 446_000).unwrap_err().to_string();
        assert!(message.contains("60000x60000 pixels") && message.contains("0.4 MB"), "{message}");
        for size in [[u64::MAX, u64::MAX], [1 << 31, 1 << 31], [1, 1 << 40]] {
            assert!(check(size, 1000).is_err(), "{size:?}");
        }
        // Believed, but more than any machine has.
        let error = check([1 << 31, 1 << 28], u64::MAX).unwrap_err();
        assert!(matches!(error, ReadError::TooLarge { .. }), "{error}");
    }
}
