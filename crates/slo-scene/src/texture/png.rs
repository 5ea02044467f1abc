//! PNG images.

use std::io::Cursor;

use png::{BitDepth, ColorType, Decoder, DecodingError, Limits, Transformations};

use super::decoded::{LoadedTexture, NEVER_SHOWN, check_size, damaged, texture};
use super::image::Channels;
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
    check_size(width, height)?;
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
    let mut warnings = Vec::new();
    let channels = color.samples();
    let has_alpha = matches!(color, ColorType::GrayscaleAlpha | ColorType::Rgba);
    let alpha_bytes = usize::from(depth == BitDepth::Sixteen) + 1;
    let is_transparent =
        |pixel: &[u8]| pixel[pixel.len() - alpha_bytes..].iter().any(|byte| *byte != u8::MAX);
    if has_alpha && pixels.chunks_exact(channels * alpha_bytes).any(is_transparent) {
        warnings.push(NEVER_SHOWN.to_owned());
    }
    let rgb = match depth {
        BitDepth::Sixteen => {
            let values = pixels.chunks_exact(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]]));
            Channels::Bits16(to_rgb(values.collect(), channels))
        }
        _ => Channels::Bits8(to_rgb(pixels, channels)),
    };
    texture(width, height, rgb, warnings)
}

/// Red, green and blue of pixels that have 1 to 4 channels: grey, and alpha, which is dropped.
fn to_rgb<C: Copy>(mut values: Vec<C>, channels: usize) -> Vec<C> {
    match channels {
        1 | 2 => values.chunks_exact(channels).flat_map(|pixel| [pixel[0]; 3]).collect(),
        4 => {
            let pixels = values.len() / 4;
            for pixel in 0..pixels {
                values.copy_within(4 * pixel..4 * pixel + 3, 3 * pixel);
            }
            values.truncate(3 * pixels);
            values.shrink_to_fit();
            values
        }
        _ => values,
    }
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
