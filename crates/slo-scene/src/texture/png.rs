//! PNG images.

use std::io::Cursor;

use png::{BitDepth, ColorType, Decoder, DecodingError, Limits, Transformations};

use super::decoded::{LoadedTexture, check_size, damaged, texture, without_opaque_alpha};
use super::image::Alpha;
use super::texels::{Layout, Samples};
use crate::format::FileError;

/// How many times larger than its data an image can be: what the compression does at best, over
/// the eight pixels that a byte may hold.
const MOST_PIXELS_PER_BYTE: u64 = 1032 * 8;

/// Decodes an image. What its chunks say about anything but pixels is not unpacked; such a chunk
/// may have a wrong checksum.
///
/// # Errors
/// The image is damaged or too large.
pub(super) fn load(bytes: &[u8]) -> Result<LoadedTexture, FileError> {
    let failed = |error: DecodingError| damaged("PNG", &png_reason(&first_line(&error)));
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: usize::MAX });
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    decoder.set_transformations(Transformations::EXPAND);
    let info = decoder.read_header_info().map_err(failed)?;
    let (width, height) = (info.width, info.height);
    let each = if info.bit_depth == BitDepth::Sixteen { 16 } else { 4 };
    check_size(width, height, each)?;
    if u64::from(width) * u64::from(height) > bytes.len() as u64 * MOST_PIXELS_PER_BYTE {
        let reason = format!("{} bytes can't be {width} x {height} pixels", bytes.len());
        return Err(damaged("PNG", &reason));
    }
    let mut reader = decoder.read_info().map_err(failed)?;
    let (color, depth) = reader.output_color_type();
    let len = reader.output_buffer_size().unwrap_or(0);
    let mut pixels = vec![0; len];
    reader.next_frame(&mut pixels).map_err(failed)?;
    if let Err(error @ DecodingError::IoError(_)) = reader.finish() {
        return Err(failed(error));
    }
    let layout = match color {
        ColorType::Grayscale => Layout::Grey,
        ColorType::GrayscaleAlpha => Layout::GreyAlpha,
        ColorType::Rgb | ColorType::Indexed => Layout::Rgb,
        ColorType::Rgba => Layout::Rgba,
    };
    let (layout, samples, alpha) = match depth {
        BitDepth::Sixteen => {
            let values = pixels.chunks_exact(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]]));
            let (layout, values, alpha) =
                without_opaque_alpha(layout, values.collect(), u16::MAX, Alpha::Straight);
            (layout, Samples::Bits16(values), alpha)
        }
        _ => {
            let (layout, values, alpha) =
                without_opaque_alpha(layout, pixels, u8::MAX, Alpha::Straight);
            (layout, Samples::Bits8(values), alpha)
        }
    };
    texture(width, height, layout, samples, alpha, Vec::new())
}

/// What the decoder says, without what follows.
fn first_line(error: &DecodingError) -> String {
    match error {
        DecodingError::IoError(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => {
            "it is cut off".to_owned()
        }
        error => error.to_string().lines().next().unwrap_or_default().to_owned(),
    }
}

/// What the PNG reader says of a damaged file, without what it says for programmers only.
pub fn png_reason(said: &str) -> String {
    let chunk = said.split_once("ChunkType { type: ").and_then(|(before, rest)| {
        // A damaged name is escaped, with braces.
        let (name, rest) = rest.split_once(", critical: ")?;
        Some((before, name, rest.split_once('}')?.1))
    });
    match chunk {
        Some((before, name, _)) if before.starts_with("CRC error") => {
            format!("the checksum of its {name} chunk is wrong")
        }
        Some((before, ..)) if before.starts_with("Unrecognized critical chunk") => {
            "it has a chunk of a kind that PNG does not know".into()
        }
        Some((before, name, after)) => format!("{before}{name}{after}"),
        None if said.starts_with("Corrupt deflate stream") => "its compressed data is wrong".into(),
        None => said.to_owned(),
    }
}
