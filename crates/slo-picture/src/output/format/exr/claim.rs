//! Whether an EXR file can hold what its header says.

use exr::meta::header::Header;

use super::super::claim::{ReadError, bytes};

/// Bytes of all channels that any EXR file may hold, and of one of its blocks.
const MOST_BYTES: u64 = 1 << 30;
const MOST_BLOCK_BYTES: u64 = 1 << 28;
/// How far a byte of a file can be expanded: Deflate does no more.
const MOST_EXPANSION: u64 = 1032;

/// Whether a file of `file_bytes` can hold what the header of one of its layers says.
///
/// # Errors
/// What is not believed.
pub(super) fn check(header: &Header, file_bytes: u64) -> Result<(), ReadError> {
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
            "its header claims {width}x{height} pixels of {}, too many for a file of {}",
            bytes(per_pixel),
            bytes(file_bytes)
        )));
    }
    Ok(())
}
