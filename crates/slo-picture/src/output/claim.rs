//! What the header of a picture says of its size, against the file that it is in.
//!
//! A header of a few bytes can promise any size. Before memory is asked for, the promise is held
//! against the length of the file.

use std::fmt;
use std::io;

use exr::meta::header::Header;

/// Pixels that any picture may have: 8K UHD fits.
const MOST_PIXELS: u64 = 1 << 25;
/// Pixels for each byte of a larger file: pictures that are rendered have fewer by far.
const MOST_PIXELS_PER_BYTE: u64 = 32;
/// Bytes of all channels that any EXR file may hold, and of one of its blocks.
const MOST_BYTES: u64 = 1 << 30;
const MOST_BLOCK_BYTES: u64 = 1 << 28;
/// How far a byte of a file can be expanded: Deflate does no more.
const MOST_EXPANSION: u64 = 1032;

/// Why a picture can't be read.
#[derive(Debug)]
pub enum ReadError {
    /// What the system says.
    Io(io::Error),
    /// What is wrong with the file.
    Bad(String),
    /// Memory does not suffice.
    TooLarge {
        /// Columns and rows of the picture.
        size: [u64; 2],
        /// What it needs.
        bytes: u64,
    },
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Io(error) => write!(f, "{error}"),
            Self::Bad(why) => f.write_str(why),
            Self::TooLarge { size: [width, height], bytes } => write!(
                f,
                "not enough memory: its {width}x{height} pixels need {:.1} GB",
                *bytes as f64 / 1e9
            ),
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
/// A file that is too short for such a picture; memory does not suffice.
pub(super) fn pixels(size: [u64; 2], file_bytes: u64) -> Result<Vec<[f32; 3]>, ReadError> {
    let [width, height] = size;
    let count = width.saturating_mul(height);
    if count > MOST_PIXELS.max(file_bytes.saturating_mul(MOST_PIXELS_PER_BYTE)) {
        return Err(ReadError::Bad(format!(
            "it says that it has {width}x{height} pixels, which is not believed of a file of {}: \
             at most 33.5 million pixels are, or {MOST_PIXELS_PER_BYTE} for each byte",
            bytes(file_bytes)
        )));
    }
    let too_large = ReadError::TooLarge { size, bytes: count.saturating_mul(12) };
    let Ok(len) = usize::try_from(count) else { return Err(too_large) };
    let mut pixels = Vec::new();
    if pixels.try_reserve_exact(len).is_err() {
        return Err(too_large);
    }
    pixels.resize(len, [0.0; 3]);
    Ok(pixels)
}

/// Whether a file of `file_bytes` can hold what the header of one of its layers says.
///
/// # Errors
/// What can't be.
pub(super) fn check_layer(header: &Header, file_bytes: u64) -> Result<(), ReadError> {
    let wide = |n: usize| n as u64;
    let [width, height] = [header.layer_size.0, header.layer_size.1].map(wide);
    let per_pixel = wide(header.channels.bytes_per_pixel);
    let block = header.max_block_pixel_size();
    let block = wide(block.0).saturating_mul(wide(block.1)).saturating_mul(per_pixel);
    let all = width.saturating_mul(height).saturating_mul(per_pixel);
    // A table at the beginning has 8 bytes for each chunk.
    if wide(header.chunk_count).saturating_mul(8) > file_bytes {
        return Err(ReadError::bad("it was cut off: it is too short for its table of chunks"));
    }
    if all > MOST_BYTES.max(file_bytes.saturating_mul(MOST_EXPANSION))
        || block > MOST_BLOCK_BYTES.max(file_bytes.saturating_mul(8))
    {
        return Err(ReadError::Bad(format!(
            "it says that it has {width}x{height} pixels of {}, which is not believed of a file of {}",
            bytes(per_pixel),
            bytes(file_bytes)
        )));
    }
    Ok(())
}

fn bytes(bytes: u64) -> String {
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
    fn a_promise_is_held_against_the_file() {
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
