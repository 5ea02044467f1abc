//! What a block with DWA compression says about its own size, which its decoder believes.

use exr::block::chunk::{Chunk, CompressedBlock};
use exr::compression::Compression;
use exr::meta::header::Header;

/// Places of the counters of unpacked values at the beginning of a block, among numbers of 64 bits:
/// bytes of other channels, bytes of runs and what they unpack to, coefficients of both kinds.
const COUNTERS: [usize; 5] = [1, 6, 7, 8, 9];

/// Whether a block of the image does not promise more values than it has room for.
pub(super) fn is_believable(part: &Header, chunk: &Chunk) -> bool {
    if !matches!(part.compression, Compression::DWAA(_) | Compression::DWAB(_)) {
        return true;
    }
    let bytes = match &chunk.compressed_block {
        CompressedBlock::ScanLine(lines) => &lines.compressed_pixels_le,
        CompressedBlock::Tile(tile) => &tile.compressed_pixels_le,
        _ => return false,
    };
    let Ok(place) = part.get_block_data_indices(&chunk.compressed_block) else { return false };
    let Ok(bounds) = part.get_absolute_block_pixel_coordinates(place) else { return false };
    let (columns, rows) = (bounds.size.0, bounds.size.1);
    // A block that compression would enlarge is stored as it is.
    if bytes.len() == columns * rows * part.channels.bytes_per_pixel {
        return true;
    }
    // Coefficients come in squares of 8 x 8; runs may make bytes more instead of fewer.
    let room = columns.next_multiple_of(8) * rows.next_multiple_of(8);
    let most = 2 * (room * part.channels.bytes_per_pixel) as u64;
    let counters =
        bytes.chunks_exact(8).map(|c| u64::from_le_bytes(c.try_into().unwrap_or_default()));
    let counters: Vec<_> = counters.take(10).collect();
    COUNTERS.iter().all(|&place| counters.get(place).is_none_or(|&count| count <= most))
}
