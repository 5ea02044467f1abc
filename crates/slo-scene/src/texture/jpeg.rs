//! JPEG images: baseline and progressive, in any number of scans.

mod structure;
#[cfg(test)]
mod tests;

use jpeg_decoder::{Decoder, Error, PixelFormat};

use super::decoded::{LoadedTexture, check_size, damaged, texture};
use super::image::Alpha;
use super::texels::{Layout, Samples};
use crate::format::FileError;
use structure::{Structure, unsupported};

/// Decodes an image. Pixels that are turned by EXIF data stay as they are stored, with a warning.
///
/// # Errors
/// The image is damaged, too large, or of a kind that is not read.
pub(super) fn load(bytes: &[u8]) -> Result<LoadedTexture, FileError> {
    let structure = Structure::of(bytes)?;
    // Samples, and the coefficients of all of them at once in a progressive image.
    check_size(structure.width, structure.height, 12)?;
    structure.check_data()?;
    // The decoder takes zeros for data that is missing: the stream that it gets ends in errors.
    let mut decoder = Decoder::new(&structure.stream[..]);
    let pixels = decoder.decode().map_err(|error| failed(&error))?;
    let info = decoder.info().ok_or_else(|| damaged("JPEG", "it has no pixels"))?;
    let (layout, samples) = match info.pixel_format {
        PixelFormat::RGB24 => (Layout::Rgb, pixels),
        PixelFormat::L8 => (Layout::Grey, pixels),
        PixelFormat::CMYK32 => (Layout::Rgb, pixels.chunks_exact(4).flat_map(from_cmyk).collect()),
        PixelFormat::L16 => return Err(unsupported("16 bits a channel are not read")),
    };
    let mut warnings = Vec::new();
    if !structure.has_end {
        warnings.push("the file is cut off behind the last pixel".to_owned());
    }
    if decoder.exif_data().is_some_and(is_turned) {
        warnings.push(
            "its EXIF data ask to turn or mirror it, but a texture is used as it is stored"
                .to_owned(),
        );
    }
    let [width, height] = [info.width, info.height].map(u32::from);
    texture(width, height, layout, Samples::Bits8(samples), Alpha::None, warnings)
}

/// Red, green and blue of cyan, magenta, yellow and black ink.
fn from_cmyk(ink: &[u8]) -> [u8; 3] {
    let light = |ink: u8| 255 - u32::from(ink);
    let black = light(ink[3]);
    [ink[0], ink[1], ink[2]].map(|ink| ((light(ink) * black + 127) / 255) as u8)
}

/// What to say about an image that can't be decoded.
fn failed(error: &Error) -> FileError {
    match error {
        Error::Unsupported(feature) => unsupported(&format!("{feature:?} is not supported")),
        Error::Format(reason) if reason == "failed to decode huffman code" => {
            damaged("JPEG", "its data is wrong or ends early")
        }
        Error::Format(reason) => damaged("JPEG", reason),
        Error::Io(_) => damaged("JPEG", "it is cut off"),
        Error::Internal(reason) => damaged("JPEG", &reason.to_string()),
    }
}

/// Whether EXIF data (from the TIFF header on) ask for another orientation than the stored one.
fn is_turned(exif: &[u8]) -> bool {
    orientation(exif).is_some_and(|orientation| (2..=8).contains(&orientation))
}

/// The tag 0x0112 of the first directory.
fn orientation(exif: &[u8]) -> Option<u16> {
    let is_little = exif.starts_with(b"II");
    let short = |at: usize| {
        let bytes = exif.get(at..at + 2)?.try_into().ok()?;
        Some(if is_little { u16::from_le_bytes(bytes) } else { u16::from_be_bytes(bytes) })
    };
    let long = |at: usize| {
        let bytes = exif.get(at..at + 4)?.try_into().ok()?;
        Some(if is_little { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) })
    };
    let directory = long(4)? as usize;
    let entries = (0..usize::from(short(directory)?)).map(|i| directory + 2 + 12 * i);
    let entry = entries.into_iter().find(|&entry| short(entry) == Some(0x0112))?;
    short(entry + 8)
}
