//! OpenEXR images: scan lines and tiles, half floats, floats and whole numbers.

mod channels;
mod dwa;
#[cfg(test)]
mod tests;

use std::collections::HashSet;
use std::io::Cursor;
use std::panic;

use exr::block::UncompressedBlock;
use exr::block::chunk::{Chunk, CompressedBlock};
use exr::block::reader::{ChunksReader, Reader};
use exr::compression::Compression;
use exr::math::Vec2;
use exr::meta::attribute::SampleType;
use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData};

use super::decoded::{LoadedTexture, check_size, damaged, texture, without_opaque_alpha};
use super::image::Alpha;
use super::texels::Samples;
use super::unusable::Unusable;
use crate::format::FileError;
use channels::Choice;

/// Bytes of pixels that a header may promise whatever the length of the file, in the image and in
/// one of its blocks.
const MOST_UNSEEN: u64 = 1 << 28;

/// How far a byte of a larger file can be expanded: Deflate does no more.
const MOST_EXPANSION: u64 = 1032;

/// Decodes an image.
///
/// # Errors
/// The image is damaged, too large, or of a kind that is not read.
pub(super) fn load(bytes: &[u8]) -> Result<LoadedTexture, FileError> {
    // At some damaged blocks, the decoders of the crate panic.
    panic::catch_unwind(|| decode(bytes))
        .unwrap_or_else(|_| Err(damaged("EXR", "its pixels can't be decoded")))
}

fn decode(bytes: &[u8]) -> Result<LoadedTexture, FileError> {
    let reader = Reader::read_from_buffered(Cursor::new(bytes), false).map_err(failed)?;
    let parts = reader.headers();
    check_claims(parts, bytes.len() as u64)?;
    let choice = channels::choose(parts)?;
    let part = &parts[choice.part];
    let [width, height] = sides(part.layer_size)?;
    // Four floats at most, of which the blocks of the file are unpacked one by one.
    check_size(width, height, 16)?;
    let mut warnings = oddities(part);
    let is_half = channels::are_halves(part, &choice.channels);
    let is_wanted = |part, level| part == choice.part && level == Vec2(0, 0);
    let chunks =
        reader.filter_chunks(false, |_, tile, block| is_wanted(block.layer, tile.level_index));
    let chunks = chunks.map_err(failed)?;
    let meta = chunks.meta_data().clone();
    let blocks = Blocks { meta: &meta, choice: &choice, seen: HashSet::new() };
    let mut unusable = Unusable::default();
    let (layout, samples, alpha) = if is_half {
        let color = |found: &mut Unusable, bits| found.half(bits);
        let alpha = |found: &mut Unusable, bits| found.half_alpha(bits);
        let halves = blocks.collect(chunks, &mut unusable, half_bits, color, alpha)?;
        let (layout, halves, alpha) =
            without_opaque_alpha(choice.layout, halves, 0x3c00, Alpha::Premultiplied);
        (layout, Samples::Half(halves), alpha)
    } else {
        let color = |found: &mut Unusable, value| found.float(value);
        let alpha = |found: &mut Unusable, value| found.float_alpha(value);
        let floats = blocks.collect(chunks, &mut unusable, float, color, alpha)?;
        let (layout, floats, alpha) =
            without_opaque_alpha(choice.layout, floats, 1.0, Alpha::Premultiplied);
        (layout, Samples::Float(floats), alpha)
    };
    warnings.extend(unusable.warnings());
    texture(width, height, layout, samples, alpha, warnings)
}

/// The blocks of the image.
struct Blocks<'a> {
    meta: &'a MetaData,
    choice: &'a Choice,
    /// Positions of those that were found.
    seen: HashSet<Vec2<usize>>,
}

impl Blocks<'_> {
    /// The channels of all pixels, by what `read` makes of their bytes and `color` and `alpha` of
    /// that.
    fn collect<T: Copy + Default>(
        mut self,
        chunks: impl ChunksReader,
        unusable: &mut Unusable,
        read: impl Fn(&[u8], SampleType) -> T,
        color: impl Fn(&mut Unusable, T) -> T,
        alpha: impl Fn(&mut Unusable, T) -> T,
    ) -> Result<Vec<T>, FileError> {
        let part = &self.meta.headers[self.choice.part];
        let Vec2(width, height) = part.layer_size;
        let (channels, has_alpha) = (self.choice.layout.channels(), self.choice.layout.has_alpha());
        let mut pixels = vec![T::default(); width * height * channels];
        for chunk in chunks {
            let block = self.decompress(chunk.map_err(failed)?)?;
            let Vec2(x0, y0) = block.index.pixel_position;
            let Vec2(columns, rows) = block.index.pixel_size;
            for row in 0..rows {
                let to = ((y0 + row) * width + x0) * channels;
                let to = &mut pixels[to..to + columns * channels];
                for (place, &channel) in self.choice.channels.iter().enumerate() {
                    let is_alpha = has_alpha && place + 1 == channels;
                    let (from, kind) = line(part, &block, row, channel);
                    let values = from.chunks_exact(kind.bytes_per_sample());
                    for (pixel, bytes) in to.chunks_exact_mut(channels).zip(values) {
                        let value = read(bytes, kind);
                        pixel[place] =
                            if is_alpha { alpha(unusable, value) } else { color(unusable, value) };
                    }
                }
            }
        }
        Ok(pixels)
    }

    /// The pixels of a chunk.
    fn decompress(&mut self, chunk: Chunk) -> Result<UncompressedBlock, FileError> {
        let part = &self.meta.headers[self.choice.part];
        if chunk.layer_index != self.choice.part || !is_inside(part, &chunk.compressed_block) {
            return Err(damaged("EXR", "its table of blocks is wrong"));
        }
        if !dwa::is_believable(part, &chunk) {
            return Err(damaged("EXR", "a block promises more than it has room for"));
        }
        let block = UncompressedBlock::decompress_chunk(chunk, self.meta, false).map_err(failed)?;
        // The table has as many entries as there are blocks: none is missing if none comes twice.
        if !self.seen.insert(block.index.pixel_position) {
            return Err(damaged("EXR", "its table names a block twice"));
        }
        Ok(block)
    }
}

/// Whether a block is one of the image in its full size.
fn is_inside(part: &Header, block: &CompressedBlock) -> bool {
    let Vec2(width, height) = part.layer_size;
    match (block, part.blocks) {
        (CompressedBlock::Tile(tile), BlockDescription::Tiles(tiles)) => {
            let Vec2(x, y) = tile.coordinates.tile_index;
            tile.coordinates.level_index == Vec2(0, 0)
                && x.saturating_mul(tiles.tile_size.0) < width
                && y.saturating_mul(tiles.tile_size.1) < height
        }
        (CompressedBlock::ScanLine(lines), BlockDescription::ScanLines) => {
            let first = i64::from(part.own_attributes.layer_position.1);
            let y = i64::from(lines.y_coordinate) - first;
            (0..height as i64).contains(&y)
                && y % part.compression.scan_lines_per_block() as i64 == 0
        }
        _ => false,
    }
}

/// The values of a channel in a row of a block, and what they are.
fn line<'b>(
    part: &Header,
    block: &'b UncompressedBlock,
    row: usize,
    channel: usize,
) -> (&'b [u8], SampleType) {
    let list = &part.channels.list;
    let columns = block.index.pixel_size.0;
    let before: usize = list[..channel].iter().map(|c| c.sample_type.bytes_per_sample()).sum();
    let start = columns * (row * part.channels.bytes_per_pixel + before);
    let kind = list[channel].sample_type;
    (&block.data[start..start + columns * kind.bytes_per_sample()], kind)
}

/// The bits of a half float.
fn half_bits(bytes: &[u8], _: SampleType) -> u16 {
    u16::from_ne_bytes([bytes[0], bytes[1]])
}

/// A value of any kind.
fn float(bytes: &[u8], kind: SampleType) -> f32 {
    match kind {
        SampleType::F16 => exr::prelude::f16::from_bits(half_bits(bytes, kind)).to_f32_const(),
        SampleType::F32 => f32::from_ne_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
        SampleType::U32 => u32::from_ne_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]) as f32,
    }
}

/// Refuses headers that promise more than the file can hold.
fn check_claims(parts: &[Header], file_bytes: u64) -> Result<(), FileError> {
    let wide = |n: usize| n as u64;
    // A table at the beginning has 8 bytes for each block.
    let blocks = parts.iter().fold(0, |sum: u64, part| sum.saturating_add(wide(part.chunk_count)));
    if blocks.saturating_mul(8) > file_bytes {
        return Err(damaged("EXR", "it is cut off"));
    }
    for part in parts {
        let per_pixel = wide(part.channels.bytes_per_pixel);
        let bytes = |Vec2(width, height): Vec2<usize>| {
            wide(width).saturating_mul(wide(height)).saturating_mul(per_pixel)
        };
        let most = MOST_UNSEEN.max(file_bytes.saturating_mul(MOST_EXPANSION));
        let most_of_block = MOST_UNSEEN.max(file_bytes.saturating_mul(8));
        if bytes(part.layer_size) > most || bytes(part.max_block_pixel_size()) > most_of_block {
            let Vec2(width, height) = part.layer_size;
            let reason = format!("{file_bytes} bytes can't be {width} x {height} pixels");
            return Err(damaged("EXR", &reason));
        }
    }
    Ok(())
}

fn sides(Vec2(width, height): Vec2<usize>) -> Result<[u32; 2], FileError> {
    match (u32::try_from(width), u32::try_from(height)) {
        (Ok(width), Ok(height)) => Ok([width, height]),
        _ => Err(damaged("EXR", "its size is wrong")),
    }
}

/// What is not as the author of the image may expect.
fn oddities(part: &Header) -> Vec<String> {
    let mut warnings = Vec::new();
    let display = part.shared_attributes.display_window;
    if part.data_window() != display {
        let [data, display] = [part.layer_size, display.size];
        warnings.push(format!(
            "its data window ({} x {}) is not its display window ({} x {}): the texture is the \
             data window",
            data.0, data.1, display.0, display.1
        ));
    }
    if matches!(part.compression, Compression::DWAA(_) | Compression::DWAB(_)) {
        warnings.push(
            "its compression (DWA) gives slightly different values on different kinds of              processors: pictures may differ in their last bits"
                .to_owned(),
        );
    }
    warnings
}

/// What to say about an image that can't be decoded.
fn failed(error: exr::error::Error) -> FileError {
    use std::io::ErrorKind;
    match error {
        exr::error::Error::Io(error) if error.kind() == ErrorKind::UnexpectedEof => {
            damaged("EXR", "it is cut off")
        }
        // Offsets outside of the file.
        exr::error::Error::Io(_) => damaged("EXR", "its table of blocks is wrong"),
        exr::error::Error::NotSupported(what) if what.contains("subsampling") => {
            unsupported("some of its channels have fewer values than pixels")
        }
        exr::error::Error::NotSupported(what) => unsupported(&what),
        exr::error::Error::Invalid(what) if what == "reference to missing bytes" => {
            damaged("EXR", "it is cut off")
        }
        exr::error::Error::Invalid(what) => damaged("EXR", &what),
        exr::error::Error::Aborted => damaged("EXR", "it can't be decoded"),
    }
}

/// What to say about an image of a rare kind.
fn unsupported(what: &str) -> FileError {
    FileError::whole_file(format!("the EXR image can't be read: {what}"))
        .with_help("save it as an RGB image of half floats, with ZIP compression")
}
