//! Pictures that are there already -> their values.

use std::io::{BufRead, BufReader, Cursor, Seek};
use std::path::Path;

use exr::math::Vec2;
use exr::meta::attribute::IntegerBounds;
use exr::prelude::{ReadChannels, ReadLayers};

use super::file::open_regular;
use super::png::reason;
use super::seal::{self, Seal};
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
    pub fn read(path: &Path) -> Result<Self, String> {
        let file = open_regular(path).map_err(|error| error.to_string())?;
        Self::decode(BufReader::new(file))
    }

    /// The picture in the bytes of a PNG or EXR file.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn from_bytes(bytes: Vec<u8>) -> Result<Self, String> {
        Self::decode(Cursor::new(bytes))
    }

    fn decode(mut input: impl BufRead + Seek) -> Result<Self, String> {
        let start = input.fill_buf().map_err(|error| error.to_string())?;
        match start {
            [0x89, b'P', b'N', b'G', ..] => decode_png(input),
            [0x76, 0x2f, 0x31, 0x01, ..] => decode_exr(input),
            _ => Err("not a PNG or EXR picture".into()),
        }
    }

    /// Values as the screen shows them: sRGB from 0 to 1.
    pub fn shown(&self) -> Image {
        self.with(|value| match self.values {
            Values::Raw | Values::Srgb => value,
            Values::Linear => srgb(value.clamp(0.0, 1.0)),
        })
    }

    /// Linear values; those of a file without a curve as they are.
    pub fn linear(&self) -> Image {
        self.with(|value| match self.values {
            Values::Srgb => linear(value),
            Values::Raw | Values::Linear => value,
        })
    }

    /// The pixels of `area`, which is counted in the larger picture where this is a crop; `None`
    /// where they are not all there.
    pub fn cut(&self, area: Area) -> Option<Image> {
        let own = self.area();
        if !own.holds(&area) {
            return None;
        }
        let width = own.width() as usize;
        let row = |y: u32| {
            let start = (y - own.y0) as usize * width + (area.x0 - own.x0) as usize;
            &self.image.rgb[start..start + area.width() as usize]
        };
        let rgb = (area.y0..area.y1).flat_map(row).copied().collect();
        Some(Image { width: area.width(), height: area.height(), rgb })
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

    fn with(&self, change: impl Fn(f32) -> f32) -> Image {
        let rgb = self.image.rgb.iter().map(|rgb| rgb.map(&change)).collect();
        Image { width: self.image.width, height: self.image.height, rgb }
    }
}

fn decode_png(mut input: impl BufRead + Seek) -> Result<Raster, String> {
    chunks::check(&mut input).map_err(|error| error.to_string())?;
    input.rewind().map_err(|error| error.to_string())?;
    let mut decoder = png::Decoder::new(input);
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(|error| reason(&error))?;
    let values = if reader.info().srgb.is_some() { Values::Srgb } else { Values::Raw };
    let size = reader.output_buffer_size().ok_or("the picture is too large")?;
    let mut bytes = vec![0; size];
    let info = reader.next_frame(&mut bytes).map_err(|error| reason(&error))?;
    // The compressed data may be wrong behind the last pixel.
    reader.finish().map_err(|error| reason(&error))?;
    let channels = info.color_type.samples();
    let samples: Vec<f32> = match info.bit_depth {
        png::BitDepth::Sixteen => {
            let pairs = bytes.as_chunks::<2>().0;
            pairs.iter().map(|pair| f32::from(u16::from_be_bytes(*pair)) / 65_535.0).collect()
        }
        _ => bytes.iter().map(|&byte| f32::from(byte) / 255.0).collect(),
    };
    let pixel = |pixel: &[f32]| match pixel {
        [r, g, b, ..] => [*r, *g, *b],
        [gray, ..] => [*gray; 3],
        [] => [0.0; 3],
    };
    let rgb = samples.chunks_exact(channels).map(pixel).collect();
    Ok(Raster { image: Image { width: info.width, height: info.height, rgb }, values, crop: None })
}

fn decode_exr(mut input: impl BufRead + Seek) -> Result<Raster, String> {
    if seal::look(&mut input).map_err(|error| error.to_string())? == Seal::Broken {
        return Err("it is damaged: its checksum is wrong".into());
    }
    input.rewind().map_err(|error| error.to_string())?;
    let read = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| (size.width(), vec![[0.0f32; 3]; size.width() * size.height()]),
            |(width, rgb): &mut (usize, Vec<[f32; 3]>), at, (r, g, b): (f32, f32, f32)| {
                rgb[at.y() * *width + at.x()] = [r, g, b];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(input)
        .map_err(|error| error.to_string())?;
    let size = read.layer_data.size;
    let rgb = read.layer_data.channel_data.pixels.1;
    let image = Image { width: size.width() as u32, height: size.height() as u32, rgb };
    let crop =
        crop(&image, read.layer_data.attributes.layer_position, read.attributes.display_window);
    Ok(Raster { image, values: Values::Linear, crop })
}

/// The place of an image in the display window; `None` where it is not inside.
fn crop(image: &Image, at: Vec2<i32>, display: IntegerBounds) -> Option<Crop> {
    let offset = |at: i32, from: i32| u32::try_from(i64::from(at) - i64::from(from)).ok();
    let (x0, y0) = (offset(at.0, display.position.0)?, offset(at.1, display.position.1)?);
    let (x1, y1) = (x0.checked_add(image.width)?, y0.checked_add(image.height)?);
    let side = |length: usize| u32::try_from(length).ok();
    let whole = Area::whole(side(display.size.0)?, side(display.size.1)?);
    Crop::of(Area { x0, y0, x1, y1 }, whole)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{bytes, sample_image};
    use super::*;
    use crate::scene::{Encoding, OutputFormat};

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
                    assert!((curved.linear().rgb[i][c] - expected).abs() <= 1.3 / steps, "{i}");
                    assert!((exr.shown().rgb[i][c] - srgb(expected)).abs() < 1e-6);
                }
            }
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
        let whole = bytes(OutputFormat::Png8, Encoding::Raw, &sample_image());
        let data = whole.windows(4).position(|name| name == b"IDAT").unwrap();
        let mut damaged = whole.clone();
        damaged[data + 8] ^= 1;
        let why = "it is damaged: the checksum of its IDAT chunk is wrong";
        assert_eq!(Raster::from_bytes(damaged.clone()).unwrap_err(), why);
        // A program that wrote wrong data wrote their checksum.
        let length = u32::from_be_bytes(*damaged[data - 4..].first_chunk().unwrap());
        let end = data + 4 + length as usize;
        let checksum = crc32fast::hash(&damaged[data..end]).to_be_bytes();
        damaged[end..end + 4].copy_from_slice(&checksum);
        assert_eq!(Raster::from_bytes(damaged).unwrap_err(), "its compressed data is wrong");
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
