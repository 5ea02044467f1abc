//! Pictures that are there already -> their values.

use std::io::{BufRead, BufReader, Cursor, Read, Seek, SeekFrom};
use std::path::Path;

use exr::meta::MetaData;
use exr::meta::header::Header;

use super::claim::{self, ReadError};
use super::file::open_regular;
use super::png::reason;
use super::read_exr::read_exr;
use super::{Crop, chunks};
use crate::film::{Area, Image, linear, srgb};

/// What the values of a file mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Values {
    /// Shares of white as the screen gets them, without a curve of the file's own.
    Raw,
    /// Shares of white on the sRGB curve.
    Srgb,
    /// Linear radiance.
    Linear,
}

/// A picture as its file has it.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    /// The values as they are; those of a PNG go from 0 to 1.
    pub image: Image,
    /// What they mean.
    pub values: Values,
    /// What of a larger picture it is; `None` where the file does not say, or all of it.
    pub crop: Option<Crop>,
}

impl Raster {
    /// The PNG or EXR picture at `path`.
    ///
    /// # Errors
    /// What the system says, or what is wrong with the file.
    pub fn read(path: &Path) -> Result<Self, ReadError> {
        Self::decode(BufReader::new(open_regular(path)?))
    }

    /// The picture in the bytes of a PNG or EXR file.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn from_bytes(bytes: Vec<u8>) -> Result<Self, ReadError> {
        Self::decode(Cursor::new(bytes))
    }

    fn decode(mut input: impl BufRead + Seek) -> Result<Self, ReadError> {
        let start = input.fill_buf()?;
        match start {
            [0x89, b'P', b'N', b'G', ..] => read_png(input),
            [0x76, 0x2f, 0x31, 0x01, ..] => read_exr(input),
            _ => Err(ReadError::bad("not a PNG or EXR picture")),
        }
    }

    /// A value as the screen shows it: sRGB from 0 to 1.
    pub fn shown(&self, value: f32) -> f32 {
        match self.values {
            Values::Raw | Values::Srgb => value,
            Values::Linear => srgb(value.clamp(0.0, 1.0)),
        }
    }

    /// A value, linear; that of a file without a curve as it is.
    pub fn linear(&self, value: f32) -> f32 {
        match self.values {
            Values::Srgb => linear(value),
            Values::Raw | Values::Linear => value,
        }
    }

    /// All values, each changed in its place.
    pub fn into_image(mut self, change: impl Fn(&Self, f32) -> f32) -> Image {
        let mut rgb = std::mem::take(&mut self.image.rgb);
        rgb.as_flattened_mut().iter_mut().for_each(|value| *value = change(&self, *value));
        Image { rgb, ..self.image }
    }

    /// The pixels of `area`, which is counted in the larger picture where this is a crop; `None`
    /// where they are not all there.
    pub fn cut(&self, area: Area) -> Option<Image> {
        let rgb = self.rows(area)?.flatten().copied().collect();
        Some(Image { width: area.width(), height: area.height(), rgb })
    }

    /// The same, row by row.
    pub fn rows(&self, area: Area) -> Option<impl Iterator<Item = &[[f32; 3]]>> {
        let own = self.area();
        if !own.holds(&area) {
            return None;
        }
        let width = own.width() as usize;
        Some((area.y0..area.y1).map(move |y| {
            let start = (y - own.y0) as usize * width + (area.x0 - own.x0) as usize;
            &self.image.rgb[start..start + area.width() as usize]
        }))
    }

    /// Which pixels of the picture it has.
    pub fn area(&self) -> Area {
        self.crop.map_or(self.whole(), |crop| crop.area)
    }

    /// All pixels of the picture.
    pub fn whole(&self) -> Area {
        let Image { width, height, .. } = self.image;
        self.crop.map_or(Area::whole(width, height), |crop| crop.whole)
    }
}

/// How many pixels the header of a picture says that there are; 0 where it can't be read.
pub fn claimed_pixels(path: &Path) -> u64 {
    let claimed = || {
        let mut input = BufReader::new(open_regular(path).ok()?);
        if input.fill_buf().ok()?.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
            let headers = MetaData::read_from_buffered(input, false).ok()?.headers;
            let pixels = |header: &Header| header.layer_size.0 as u64 * header.layer_size.1 as u64;
            return headers.iter().map(pixels).max();
        }
        // Behind the signature, and length and name of the first chunk.
        let mut start = [0; 24];
        input.read_exact(&mut start).ok()?;
        let number = |at: usize| start[at..].first_chunk().copied().map(u32::from_be_bytes);
        Some(u64::from(number(16)?) * u64::from(number(20)?))
    };
    claimed().unwrap_or(0)
}

/// Decodes row by row, so that a picture needs no more memory than its pixels.
fn read_png(mut input: impl BufRead + Seek) -> Result<Raster, ReadError> {
    let bad = |error: png::DecodingError| ReadError::Bad(reason(&error));
    chunks::check(&mut input).map_err(|error| match error.kind() {
        std::io::ErrorKind::InvalidData => ReadError::Bad(error.to_string()),
        _ => ReadError::Io(error),
    })?;
    let file_bytes = input.seek(SeekFrom::End(0))?;
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
    // The compressed data may be wrong behind the last pixel.
    reader.finish().map_err(bad)?;
    Ok(Raster { image: Image { width, height, rgb }, values, crop: None })
}

/// Where a row of a PNG file goes: its first pixel, and from one to the next.
struct Place {
    start: usize,
    step: usize,
}

/// The rows of a PNG file in their order.
fn places(width: u32, height: u32, is_interlaced: bool) -> impl Iterator<Item = Place> {
    /// First column and row, and from one to the next, of the passes of Adam7.
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

/// Puts the pixels of a row into every so manieth of `to`.
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
    use super::super::tests::{bytes, sample_image};
    use super::*;
    use slo_scene::{Encoding, OutputFormat};

    #[test]
    fn what_was_written_is_read() {
        let image = sample_image();
        let read = |format, encoding| Raster::from_bytes(bytes(format, encoding, &image)).unwrap();
        let exr = read(OutputFormat::Exr, Encoding::Raw);
        assert_eq!((exr.image.width, exr.image.height), (5, 3));
        assert_eq!(exr.image.rgb[3], image.rgb[3]);
        assert_eq!(exr.image.rgb[7], [0.0, 0.0, 0.25], "what is no number is 0");
        for (format, steps) in [(OutputFormat::Png8, 255.0), (OutputFormat::Png16, 65_535.0)] {
            let raw = read(format, Encoding::Raw);
            assert_eq!(raw.values, Values::Raw);
            let curved = read(format, Encoding::Srgb);
            assert_eq!(curved.values, Values::Srgb);
            for (i, rgb) in image.rgb.iter().enumerate().filter(|(i, _)| *i != 7) {
                for (c, radiance) in rgb.iter().enumerate() {
                    let expected = radiance.clamp(0.0, 1.0);
                    assert!((raw.image.rgb[i][c] - expected).abs() <= 0.51 / steps);
                    assert!(
                        (curved.linear(curved.image.rgb[i][c]) - expected).abs() <= 1.3 / steps,
                        "{i}"
                    );
                    assert!((exr.shown(exr.image.rgb[i][c]) - srgb(expected)).abs() < 1e-6);
                }
            }
        }
    }

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
    fn a_region_says_where_it_is() {
        let image = sample_image();
        let area = Area { x0: 7, y0: 2, x1: 12, y1: 5 };
        let whole = Area::whole(20, 10);
        let picture = super::super::Picture {
            image: &image,
            format: OutputFormat::Exr,
            encoding: Encoding::Raw,
            recipe: "{}",
            crop: Crop::of(area, whole),
        };
        let mut bytes = Cursor::new(Vec::new());
        picture.write(&mut bytes).unwrap();
        let read = Raster::from_bytes(bytes.into_inner()).unwrap();
        assert_eq!((read.area(), read.whole()), (area, whole));
        let one = Area { x0: 8, y0: 3, x1: 9, y1: 4 };
        assert_eq!(read.cut(one).unwrap().rgb, [image.rgb[6]]);
        assert_eq!(read.cut(Area { x0: 6, ..one }), None);
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

    #[test]
    fn damage_is_an_error() {
        for format in [OutputFormat::Png8, OutputFormat::Exr] {
            let whole = bytes(format, Encoding::Srgb, &sample_image());
            for length in 0..whole.len() {
                assert!(Raster::from_bytes(whole[..length].to_vec()).is_err(), "{length}");
            }
            // An EXR file whose hash has another name is one of another program.
            for at in (0..whole.len()).filter(|_| format == OutputFormat::Png8) {
                let mut damaged = whole.clone();
                damaged[at] ^= 4;
                assert!(Raster::from_bytes(damaged).is_err(), "{at}");
            }
            assert!(Raster::from_bytes([&whole[..], b"x"].concat()).is_err(), "{format:?}");
        }
    }
}
