//! Images, as their files have them.

use std::io::{Cursor, Read};

use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader};

use crate::format::FileError;

/// Texels that an image may have: 16384 x 16384, which takes 0.8 GB at 8 bits a channel.
const MAX_TEXELS: u64 = 1 << 28;

/// Bytes that an image file may have.
const MAX_FILE_BYTES: u64 = 1 << 31;

/// An RGB image with the file's values as they are (no transfer curve is removed), kept at the
/// file's precision: 3 bytes a texel, or 6 where the file has 16 bits a channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    width: u32,
    height: u32,
    channels: Channels,
}

/// Red, green and blue in turn, row-major, the top row of the image first.
#[derive(Clone, Debug, PartialEq)]
enum Channels {
    Bits8(Vec<u8>),
    Bits16(Vec<u16>),
}

impl Texture {
    /// An image of 8-bit channels: red, green, blue in turn, the top row first. `None` unless
    /// there are `3 * width * height` of them and the image has a texel.
    pub fn from_rgb8(width: u32, height: u32, channels: Vec<u8>) -> Option<Self> {
        fits(width, height, channels.len()).then_some(Self {
            width,
            height,
            channels: Channels::Bits8(channels),
        })
    }

    /// As [`from_rgb8`](Self::from_rgb8), of 16-bit channels.
    pub fn from_rgb16(width: u32, height: u32, channels: Vec<u16>) -> Option<Self> {
        fits(width, height, channels.len()).then_some(Self {
            width,
            height,
            channels: Channels::Bits16(channels),
        })
    }

    /// Pixels, 1 or more.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Pixels, 1 or more.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Red, green and blue in `[0, 1]` of the texel in column `x` from the left and row `y` from
    /// the top; columns and rows past the edge give the last one.
    #[inline(always)]
    pub fn texel(&self, x: u32, y: u32) -> [f32; 3] {
        let x = x.min(self.width - 1) as usize;
        let y = y.min(self.height - 1) as usize;
        let start = 3 * (y * self.width as usize + x);
        match &self.channels {
            Channels::Bits8(c) => color(&c[start..], 255.0),
            Channels::Bits16(c) => color(&c[start..], 65535.0),
        }
    }
}

/// The first three channels over the largest value of one.
#[inline(always)]
fn color<C: Copy + Into<f32>>(channels: &[C], most: f32) -> [f32; 3] {
    [channels[0].into() / most, channels[1].into() / most, channels[2].into() / most]
}

/// Whether so many channels make an image of that size.
fn fits(width: u32, height: u32, channels: usize) -> bool {
    let texels = u64::from(width) * u64::from(height);
    texels > 0 && u128::from(texels) * 3 == channels as u128
}

/// Reads a PNG or JPEG image; its first bytes say which it is, whatever `path_name` ends in.
///
/// Grey becomes RGB, palettes are looked up, alpha is dropped, and 16 bits are kept.
///
/// # Errors
/// The file can't be read, is neither PNG nor JPEG, is damaged, or has more than 2^28 texels.
pub fn load(path_name: &str, reader: &mut dyn Read) -> Result<Texture, FileError> {
    let bytes = read_image_file(reader)?;
    let format = known_format(path_name, &bytes)?;
    let mut decoder = ImageReader::with_format(Cursor::new(&bytes), format);
    decoder.no_limits();
    let mut decoder = decoder.into_decoder().map_err(|e| damaged(format, &e))?;
    let (width, height) = decoder.dimensions();
    check_size(width, height)?;
    decoder.set_limits(image::Limits::no_limits()).map_err(|e| damaged(format, &e))?;
    let image = DynamicImage::from_decoder(decoder).map_err(|e| damaged(format, &e))?;
    from_image(image).ok_or_else(|| FileError::whole_file("the image has no pixels"))
}

/// The whole file; a limit keeps an endless one out.
fn read_image_file(reader: &mut dyn Read) -> Result<Vec<u8>, FileError> {
    let mut bytes = Vec::new();
    reader
        .take(MAX_FILE_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(|e| FileError::whole_file(format!("the image can't be read: {e}")))?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        return Err(FileError::whole_file("the image file has more than 2 GB"));
    }
    Ok(bytes)
}

/// PNG or JPEG, by the first bytes.
fn known_format(path_name: &str, bytes: &[u8]) -> Result<ImageFormat, FileError> {
    if bytes.is_empty() {
        return Err(FileError::whole_file("the image file is empty"));
    }
    match image::guess_format(bytes) {
        Ok(format @ (ImageFormat::Png | ImageFormat::Jpeg)) => Ok(format),
        Ok(other) => Err(unknown_format(&format!("a {} image", other.extensions_str()[0]))),
        Err(_) => Err(unknown_format(&format!("no image, although it is called `{path_name}`"))),
    }
}

/// What to say about a file that starts like neither format.
fn unknown_format(what_it_is: &str) -> FileError {
    FileError::whole_file(format!("the file is {what_it_is}"))
        .with_help("textures are PNG or JPEG files")
}

/// Refuses images that would take more memory than a texture is worth.
fn check_size(width: u32, height: u32) -> Result<(), FileError> {
    let texels = u64::from(width) * u64::from(height);
    if texels <= MAX_TEXELS {
        return Ok(());
    }
    Err(FileError::whole_file(format!(
        "the image has {width} x {height} pixels, more than {MAX_TEXELS}"
    ))
    .with_help("scale it down: 16384 x 16384 pixels are the most that a texture may have"))
}

/// What to say about a file that starts right but can't be decoded.
fn damaged(format: ImageFormat, error: &ImageError) -> FileError {
    let name = if format == ImageFormat::Png { "PNG" } else { "JPEG" };
    let error = error.to_string();
    let reason = png_reason(error.lines().next().unwrap_or_default());
    let reason = reason.trim_start_matches("Format error decoding Jpeg: ").trim_end();
    FileError::whole_file(format!("the {name} image is damaged: {reason}"))
}

/// What the PNG reader says of a damaged file, without what it says for programmers only.
pub(crate) fn png_reason(said: &str) -> String {
    let said = said.trim_start_matches("Format error decoding Png: ");
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

/// RGB at the precision that the image has.
fn from_image(image: DynamicImage) -> Option<Texture> {
    let (width, height) = (image.width(), image.height());
    if image.color().bytes_per_pixel() / image.color().channel_count() > 1 {
        return Texture::from_rgb16(width, height, image.into_rgb16().into_raw());
    }
    Texture::from_rgb8(width, height, image.into_rgb8().into_raw())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a JPEG file everything up to its first scan, or less.
    const START: &[u8] = b"\xff\xd8\xff\xe0\x00\x10JFIF\x00\x01\x01\x00\x00\x01\x00\x01\x00\x00\
        \xff\xdb\x00\x43\x00\x08\x06\x06\x07\x06";

    #[test]
    fn damaged_png_images_are_told_without_debug_text() {
        let mut whole = Vec::new();
        let mut encoder = png::Encoder::new(&mut whole, 16, 16);
        encoder.set_color(png::ColorType::Rgb);
        let pixels: Vec<u8> = (0..16 * 16 * 3).map(|i| (i * i % 251) as u8).collect();
        encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
        for at in 8..whole.len() {
            let mut damaged = whole.clone();
            damaged[at] ^= 0x15;
            let Err(error) = load("a.png", &mut &damaged[..]) else { continue };
            let message = error.message;
            assert!(!message.contains(['{', '\n']), "byte {at}: {message}");
        }
        // The length of the last IDAT chunk, so that what follows it is taken for a chunk's name.
        let data = whole.windows(4).position(|name| name == b"IDAT").unwrap();
        for length in 0..=255 {
            let mut damaged = whole.clone();
            damaged[data - 1] = length;
            let Err(error) = load("a.png", &mut &damaged[..]) else { continue };
            assert!(!error.message.contains('{'), "{length}: {}", error.message);
        }
        let said = "Unrecognized critical chunk: ChunkType { type: \\u{16}I,A, critical: true, \
                    private: false, reserved: false, safecopy: false }";
        assert_eq!(png_reason(said), "it has a chunk of a kind that PNG does not know");
        let mut damaged = whole.clone();
        damaged[16] ^= 1;
        let error = load("a.png", &mut &damaged[..]).unwrap_err();
        assert_eq!(
            error.message,
            "the PNG image is damaged: the checksum of its IHDR chunk is wrong"
        );
    }

    #[test]
    fn a_cut_image_gives_one_line() {
        for length in [4, 12, 20, 24, START.len()] {
            let error = load("a.jpg", &mut &START[..length]).expect_err("it is cut");
            let message = error.message;
            assert!(message.starts_with("the JPEG image is damaged: "), "{message}");
            assert!(!message.contains('\n') && message.trim_end() == message, "{message:?}");
        }
    }
}
