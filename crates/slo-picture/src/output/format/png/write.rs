//! Pictures -> PNG files, RGB, 8 or 16 bits a channel.
//!
//! A RAW file says nothing about its colour space: viewers then show its values as they are, as the
//! thesis's program meant them. An SRGB file has the `sRGB` chunk.

use std::io::{self, Write};

use png::{BitDepth, ColorType, Encoder, EncodingError, SrgbRenderingIntent};
use rayon::prelude::*;
use slo_scene::Encoding;

use super::super::container::KEYWORD;
use super::super::picture::Picture;
use super::super::quantise::{finite, quantised};
use crate::film::Toning;

/// Number of rows that are encoded in parallel before they are written in order.
const ROWS_AT_A_TIME: u32 = 256;

/// Bits of a value.
#[derive(Clone, Copy, Debug)]
pub(in super::super) enum Depth {
    Eight,
    Sixteen,
}

/// Bytes of the rows that are encoded at a time.
pub(super) fn memory([width, height]: [u32; 2], depth: Depth) -> u64 {
    let value = match depth {
        Depth::Eight => 1,
        Depth::Sixteen => 2,
    };
    u64::from(width) * u64::from(height.min(ROWS_AT_A_TIME)) * 3 * value
}

/// Writes `picture` row by row.
pub(super) fn write(picture: &Picture, depth: Depth, out: impl Write) -> io::Result<()> {
    encode(picture, depth, out).map_err(|error| match error {
        EncodingError::IoError(error) => error,
        other => io::Error::other(other),
    })
}

fn encode(picture: &Picture, depth: Depth, out: impl Write) -> Result<(), EncodingError> {
    let mut buffered = io::BufWriter::new(out);
    let mut writer = header(picture, depth, &mut buffered)?.write_header()?;
    let mut stream = writer.stream_writer()?;
    let [_, height] = picture.image.size();
    for first in (0..height).step_by(ROWS_AT_A_TIME as usize) {
        let block = first..height.min(first + ROWS_AT_A_TIME);
        let rows: Vec<_> = block.into_par_iter().map(|y| row_bytes(picture, depth, y)).collect();
        rows.iter().try_for_each(|row| stream.write_all(row))?;
    }
    stream.finish()?;
    writer.finish()?;
    Ok(buffered.flush()?)
}

fn header<'a, W: Write>(
    picture: &Picture,
    depth: Depth,
    out: W,
) -> Result<Encoder<'a, W>, EncodingError> {
    let [width, height] = picture.image.size();
    let mut encoder = Encoder::new(out, width, height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(match depth {
        Depth::Eight => BitDepth::Eight,
        Depth::Sixteen => BitDepth::Sixteen,
    });
    if picture.look.encoding == Encoding::Srgb {
        encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    }
    encoder.add_text_chunk(KEYWORD.to_owned(), picture.recipe.to_owned())?;
    Ok(encoder)
}

/// The bytes of a row, big-endian as PNG requires.
fn row_bytes(picture: &Picture, depth: Depth, y: u32) -> Vec<u8> {
    let [width, _] = picture.image.size();
    let (toning, encoding) = (Toning::of(picture.look), picture.look.encoding);
    let values = (0..width).flat_map(|x| toning.apply(picture.image.at(x, y).map(finite)));
    let mut bytes = Vec::with_capacity(width as usize * 6);
    let value = |c: f32, max: u16| quantised(c, encoding, max);
    match depth {
        Depth::Eight => bytes.extend(values.map(|c| value(c, 255) as u8)),
        Depth::Sixteen => bytes.extend(values.flat_map(|c| value(c, u16::MAX).to_be_bytes())),
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::format::OutputFormat;
    use crate::output::format::samples::{bytes, sample_image};

    fn decode(bytes: &[u8]) -> (png::Info<'static>, Vec<u8>) {
        let mut reader = png::Decoder::new(io::Cursor::new(bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        (reader.info().clone(), pixels)
    }

    #[test]
    fn eight_bit_pixels_come_back() {
        let image = sample_image();
        let (info, pixels) = decode(&bytes(OutputFormat::Png8, Encoding::Raw, &image));
        assert_eq!((info.width, info.height, info.bit_depth), (5, 3, BitDepth::Eight));
        let expected: Vec<u8> = image
            .rgb
            .as_flattened()
            .iter()
            .map(|&c| quantised(c, Encoding::Raw, 255) as u8)
            .collect();
        assert_eq!(pixels, expected);
        assert_eq!(pixels[21..24], [0, 0, 64], "NaN and infinity are black");
    }

    #[test]
    fn sixteen_bit_pixels_come_back() {
        let image = sample_image();
        let (info, pixels) = decode(&bytes(OutputFormat::Png16, Encoding::Srgb, &image));
        assert_eq!(info.bit_depth, BitDepth::Sixteen);
        let values: Vec<u16> =
            pixels.chunks(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]])).collect();
        let expected: Vec<u16> = image
            .rgb
            .as_flattened()
            .iter()
            .map(|&c| quantised(c, Encoding::Srgb, u16::MAX))
            .collect();
        assert_eq!(values, expected);
    }

    #[test]
    fn only_srgb_files_name_their_colour_space() {
        let image = sample_image();
        let (raw, _) = decode(&bytes(OutputFormat::Png8, Encoding::Raw, &image));
        assert!(raw.srgb.is_none() && raw.gama_chunk.is_none());
        let (srgb, _) = decode(&bytes(OutputFormat::Png8, Encoding::Srgb, &image));
        assert_eq!(srgb.srgb, Some(SrgbRenderingIntent::Perceptual));
    }
}
