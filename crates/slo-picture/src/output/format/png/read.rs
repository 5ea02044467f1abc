//! PNG files -> their values and their recipe. All kinds of PNG are read, not only ours.

use std::io;

use slo_scene::texture::png_reason;

use super::super::claim::{self, ReadError};
use super::super::container::{KEYWORD, RecipeError, Source, Wholeness};
use super::super::raster::{Raster, Values};
use super::chunks;
use crate::film::Image;

/// Decodes a file row by row, so that a picture needs no more memory than its pixels.
pub(super) fn read(mut input: &mut dyn Source) -> Result<Raster, ReadError> {
    let bad = |error: png::DecodingError| ReadError::Bad(reason(&error));
    chunks::check(&mut input).map_err(|error| match error.kind() {
        io::ErrorKind::InvalidData => ReadError::Bad(error.to_string()),
        _ => ReadError::Io(error),
    })?;
    let file_bytes = input.seek(io::SeekFrom::End(0))?;
    input.rewind()?;
    let mut decoder = png::Decoder::new(input);
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(bad)?;
    let info = reader.info();
    let values = if info.srgb.is_some() { Values::Srgb } else { Values::Raw };
    let (width, height, is_interlaced) = (info.width, info.height, info.interlaced);
    let mut rgb = claim::pixels([width, height].map(u64::from), file_bytes)?;
    let (color, depth) = reader.output_color_type();
    for place in places(width, height, is_interlaced) {
        let row = reader.next_row().map_err(bad)?;
        let row = row.ok_or_else(|| ReadError::bad("its compressed data is too short"))?;
        put_row(row.data(), color.samples(), depth, &mut rgb[place.start..], place.step);
    }
    // The compressed data may be wrong after the last pixel.
    reader.finish().map_err(bad)?;
    Ok(Raster { image: Image { width, height, rgb }, values, crop: None })
}

/// The number of pixels in the header.
pub(super) fn claimed_pixels(input: &mut dyn Source) -> Option<u64> {
    // The header's chunk follows the signature: length, name, width, height.
    let mut start = [0; 24];
    input.read_exact(&mut start).ok()?;
    let number = |at: usize| start[at..].first_chunk().copied().map(u32::from_be_bytes);
    Some(u64::from(number(16)?) * u64::from(number(20)?))
}

/// The recipe in a file whose checksums are right, and whether the file is as it was written.
pub(super) fn recipe(input: &mut dyn Source) -> Result<(String, Wholeness), RecipeError> {
    let is_ours = chunks::scan(&mut *input).map_err(|error| match error.kind() {
        io::ErrorKind::InvalidData => RecipeError::Damaged(error.to_string()),
        _ => RecipeError::Io(error),
    })?;
    input.rewind().map_err(RecipeError::Io)?;
    let reader = png::Decoder::new(input)
        .read_info()
        .map_err(|error| RecipeError::NotAPicture(reason(&error)))?;
    let mut texts = reader.info().uncompressed_latin1_text.iter();
    let recipe = texts.find(|chunk| chunk.keyword == KEYWORD).ok_or(RecipeError::NoRecipe)?;
    let wholeness = if is_ours { Wholeness::Whole } else { Wholeness::Resaved };
    Ok((recipe.text.clone(), wholeness))
}

/// Why a PNG file can't be read, in words for the user.
fn reason(error: &png::DecodingError) -> String {
    match error {
        png::DecodingError::IoError(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
            "it was cut off".into()
        }
        error => png_reason(&error.to_string()),
    }
}

/// Where a row of a PNG file goes: the index of its first pixel, and the step to the next.
struct Place {
    start: usize,
    step: usize,
}

/// The places of the rows, in the order of the file.
fn places(width: u32, height: u32, is_interlaced: bool) -> impl Iterator<Item = Place> {
    /// First column and row of the passes of Adam7, and the steps to the next.
    const PASSES: [[u32; 4]; 7] = [
        [0, 0, 8, 8],
        [4, 0, 8, 8],
        [0, 4, 4, 8],
        [2, 0, 4, 4],
        [0, 2, 2, 4],
        [1, 0, 2, 2],
        [0, 1, 1, 2],
    ];
    let passes = if is_interlaced { &PASSES[..] } else { &[[0, 0, 1, 1]] };
    passes.iter().filter(move |pass| pass[0] < width).flat_map(move |&[x, y, across, down]| {
        let start = move |row: u32| row as usize * width as usize + x as usize;
        let place = move |row| Place { start: start(row), step: across as usize };
        (y..height).step_by(down as usize).map(place)
    })
}

/// Puts the pixels of a row into every `step`th element of `to`.
fn put_row(row: &[u8], channels: usize, depth: png::BitDepth, to: &mut [[f32; 3]], step: usize) {
    let to = to.iter_mut().step_by(step);
    let gray_or_color = |values: [f32; 3]| if channels < 3 { [values[0]; 3] } else { values };
    let read = |bytes: &[u8], width: usize, value: &dyn Fn(&[u8]) -> f32| {
        let at = |c: usize| bytes.get(c * width..).filter(|b| b.len() >= width).map_or(0.0, value);
        gray_or_color([0, 1, 2].map(at))
    };
    match depth {
        png::BitDepth::Sixteen => {
            let value = |b: &[u8]| f32::from(u16::from_be_bytes([b[0], b[1]])) / 65_535.0;
            let pixels = row.chunks_exact(2 * channels);
            to.zip(pixels).for_each(|(to, bytes)| *to = read(bytes, 2, &value));
        }
        _ => {
            let value = |b: &[u8]| f32::from(b[0]) / 255.0;
            let pixels = row.chunks_exact(channels);
            to.zip(pixels).for_each(|(to, bytes)| *to = read(bytes, 1, &value));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::format::samples::{bytes, sample_image};
    use crate::output::format::{Encoding, OutputFormat, Raster};

    /// Rows of a PNG file come in passes, and its values in several forms.
    #[test]
    fn pictures_of_others_are_read() {
        use png::{BitDepth, ColorType};
        let (width, height) = (13u32, 11u32);
        let gray = |i: u32| (i * 37 % 256) as u8;
        let of = |color: ColorType, depth: BitDepth, data: &[u8], palette: Option<Vec<u8>>| {
            let mut bytes = Vec::new();
            let mut encoder = png::Encoder::new(&mut bytes, width, height);
            encoder.set_color(color);
            encoder.set_depth(depth);
            if let Some(palette) = palette {
                encoder.set_palette(palette);
            }
            encoder.write_header().unwrap().write_image_data(data).unwrap();
            Raster::from_bytes(bytes).unwrap().image.rgb
        };
        let pixels: Vec<u32> = (0..width * height).collect();
        let grays: Vec<u8> = pixels.iter().map(|&i| gray(i)).collect();
        let expected: Vec<[f32; 3]> = grays.iter().map(|&g| [f32::from(g) / 255.0; 3]).collect();
        let each = |count: usize, last: Option<u8>| -> Vec<u8> {
            grays.iter().flat_map(|&g| std::iter::repeat_n(g, count).chain(last)).collect()
        };
        let eight = BitDepth::Eight;
        assert_eq!(of(ColorType::Grayscale, eight, &grays, None), expected);
        assert_eq!(of(ColorType::GrayscaleAlpha, eight, &each(1, Some(7)), None), expected);
        assert_eq!(of(ColorType::Rgb, eight, &each(3, None), None), expected);
        assert_eq!(of(ColorType::Rgba, eight, &each(3, Some(9)), None), expected);
        assert_eq!(of(ColorType::Rgb, BitDepth::Sixteen, &each(6, None), None), expected);
        let palette = (0..=255u8).flat_map(|i| [i; 3]).collect();
        assert_eq!(of(ColorType::Indexed, eight, &grays, Some(palette)), expected);
        let row = |row: &[u8]| {
            let bit = |byte: &[u8]| byte.iter().enumerate().map(|(i, g)| (g & 1) << (7 - i)).sum();
            row.chunks(8).map(bit).collect::<Vec<u8>>()
        };
        let bits: Vec<u8> = grays.chunks(width as usize).flat_map(row).collect();
        let expected: Vec<[f32; 3]> = grays.iter().map(|&g| [f32::from(g & 1); 3]).collect();
        assert_eq!(of(ColorType::Grayscale, BitDepth::One, &bits, None), expected);
    }

    #[test]
    fn every_pixel_of_an_interlaced_picture_has_its_row() {
        for (width, height) in [(1, 1), (2, 3), (4, 1), (1, 5), (5, 1), (8, 8), (13, 11), (3, 20)] {
            let mut found = vec![0; (width * height) as usize];
            for Place { start, step } in places(width, height, true) {
                let row = start / width as usize;
                let end = (row + 1) * width as usize;
                (start..end).step_by(step).for_each(|at| found[at] += 1);
            }
            assert!(found.iter().all(|&count| count == 1), "{width}x{height}: {found:?}");
            assert_eq!(places(width, height, false).count(), height as usize);
        }
    }

    #[test]
    fn damage_is_told_in_words() {
        let told = |bytes| Raster::from_bytes(bytes).unwrap_err().to_string();
        let whole = bytes(OutputFormat::Png8, Encoding::Raw, &sample_image());
        let data = whole.windows(4).position(|name| name == b"IDAT").unwrap();
        let mut damaged = whole.clone();
        damaged[data + 8] ^= 1;
        let why = "it is damaged: the checksum of its IDAT chunk is wrong";
        assert_eq!(told(damaged.clone()), why);
        // A program that wrote wrong data wrote their checksum.
        let length = u32::from_be_bytes(*damaged[data - 4..].first_chunk().unwrap());
        let end = data + 4 + length as usize;
        let checksum = crc32fast::hash(&damaged[data..end]).to_be_bytes();
        damaged[end..end + 4].copy_from_slice(&checksum);
        assert_eq!(told(damaged), "its compressed data is wrong");
    }
}
