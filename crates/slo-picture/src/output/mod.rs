//! Pictures as files: PNG, EXR, names, the recipe inside; never half-written.
//!
//! The bytes of a file depend on the picture and its recipe only: no clock, no host, no thread
//! count, no order of a hash map.

mod chunks;
mod claim;
mod companion;
mod continuation;
mod crop;
mod exr;
mod file;
mod finished;
mod map;
mod name;
mod origin;
mod outcome;
mod png;
mod read;
mod read_exr;
mod recipe;
mod restore;
mod seal;
mod state_check;
mod state_file;
mod values;

use std::io::{self, Read, Seek, Write};
use std::path::Path;

use file::Candid;

pub use claim::ReadError;
pub use companion::{check_companion, is_companion, map_format, write_sheet};
pub use continuation::{continues, has_same_samples};
pub use crop::Crop;
pub use file::{check_free, check_writable, open_regular, remove_leftovers, write_atomically};
pub use finished::{Found, find_picture, find_state, find_timed_picture};
pub use map::{write_difference_map, write_error_map, write_sample_map};
pub use name::{Info, check_prefix, file_name};
pub use origin::made_by_others;
pub use outcome::{Outcome, is_denoised, with_denoiser, with_outcome, without_outcome};
pub use png::PNG_ROWS_AT_A_TIME;
pub use read::{Raster, Values, claimed_pixels};
pub use read_exr::read_layers;
pub use recipe::{
    KEYWORD, Recipe, RecipeError, encoding_keyword, layers_of, output_keyword, read_recipe,
    settings_of, steps_of, with_region, with_steps,
};
pub use restore::{RestoreError, restore};
pub use state_file::{read_state, read_subject, write_state};

use crate::film::{Image, Layer, Pixels};
use slo_scene::{Encoding, OutputFormat};

const NO_LAYERS: &[(Layer, Image)] = &[];

/// An image with all that decides its file's bytes.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    /// Linear radiance.
    pub image: &'a dyn Pixels,
    /// File format.
    pub format: OutputFormat,
    /// Transfer curve of PNG values; EXR is linear whatever it is.
    pub encoding: Encoding,
    /// The recipe as JSON, ASCII only; see [`Recipe::to_json`].
    pub recipe: &'a str,
    /// What of a larger picture it is, for EXR; `None`: all of it.
    pub crop: Option<Crop>,
}

impl Picture<'_> {
    /// Writes the picture to `path`, which holds the old file or the whole new one at any time.
    ///
    /// # Errors
    /// What the system says of creating, writing or renaming; a picture without pixels.
    pub fn save(&self, path: &Path) -> io::Result<()> {
        self.save_with(path, NO_LAYERS)
    }

    /// The same, with layers of the same size beside the colours; a PNG holds none.
    ///
    /// # Errors
    /// As [`save`](Self::save).
    pub fn save_with(&self, path: &Path, layers: &[(Layer, impl Pixels)]) -> io::Result<()> {
        write_atomically(path, |file| self.write_with(file, layers))
    }

    /// Writes the file's bytes to `out`, which is empty.
    ///
    /// # Errors
    /// Those of `out`; a picture without pixels.
    pub fn write(&self, out: impl Read + Write + Seek) -> io::Result<()> {
        self.write_with(out, NO_LAYERS)
    }

    /// The same, with layers of the same size beside the colours; a PNG holds none.
    ///
    /// # Errors
    /// As [`write`](Self::write).
    pub fn write_with(
        &self,
        out: impl Read + Write + Seek,
        layers: &[(Layer, impl Pixels)],
    ) -> io::Result<()> {
        let mut out = Candid::new(out);
        let written = match self.format {
            OutputFormat::Png8 | OutputFormat::Png16 => png::write(self, &mut out),
            OutputFormat::Exr => exr::write(self, layers, &mut out),
        };
        out.said(written)
    }

    /// Pixels with a channel that is not a finite number; such a channel is written as 0.
    pub fn not_finite(&self) -> usize {
        let [width, height] = self.image.size();
        let is_odd = |x: u32, y: u32| !self.image.at(x, y).iter().all(|c| c.is_finite());
        (0..height).map(|y| (0..width).filter(|&x| is_odd(x, y)).count()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A gradient that leaves `[0, 1]` on both sides, and one NaN.
    pub(super) fn sample_image() -> Image {
        let pixel = |i: u32| [i as f32 / 8.0 - 0.5, (i * i) as f32 / 64.0, 2.0 - i as f32 / 5.0];
        let mut rgb: Vec<_> = (0..15).map(pixel).collect();
        rgb[7] = [f32::NAN, f32::INFINITY, 0.25];
        Image { width: 5, height: 3, rgb }
    }

    pub(super) fn bytes(format: OutputFormat, encoding: Encoding, image: &Image) -> Vec<u8> {
        let picture =
            Picture { image, format, encoding, recipe: "{\n  \"frame\": 5\n}", crop: None };
        let mut out = io::Cursor::new(Vec::new());
        picture.write(&mut out).unwrap();
        out.into_inner()
    }

    #[test]
    fn the_same_picture_gives_the_same_bytes() {
        let image = sample_image();
        for format in [OutputFormat::Png8, OutputFormat::Png16, OutputFormat::Exr] {
            let once = bytes(format, Encoding::Srgb, &image);
            assert_eq!(once, bytes(format, Encoding::Srgb, &image.clone()), "{format:?}");
        }
    }

    /// A disk that is full after so many bytes.
    #[derive(Debug)]
    struct SmallDisk {
        file: io::Cursor<Vec<u8>>,
        size: usize,
        /// As the system numbers errors.
        error: i32,
    }

    impl Write for SmallDisk {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let left = self.size.saturating_sub(self.file.position() as usize);
            match left.min(bytes.len()) {
                0 if !bytes.is_empty() => Err(io::Error::from_raw_os_error(self.error)),
                most => self.file.write(&bytes[..most]),
            }
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    impl Read for SmallDisk {
        fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
            self.file.read(bytes)
        }
    }

    impl Seek for SmallDisk {
        fn seek(&mut self, to: io::SeekFrom) -> io::Result<u64> {
            self.file.seek(to)
        }
    }

    #[cfg(unix)]
    #[test]
    fn what_the_system_says_comes_through_every_encoder() {
        // EIO, ENOSPC, ESTALE, EDQUOT.
        const ERRORS: [i32; 4] = [5, 28, 116, 122];
        let noisy = |i: u32| [0, 1, 2].map(|c| (i.wrapping_mul(2_654_435_761) >> c) as f32 / 4e9);
        let image = Image { width: 90, height: 80, rgb: (0..90 * 80).map(noisy).collect() };
        for format in [OutputFormat::Png8, OutputFormat::Png16, OutputFormat::Exr] {
            let whole = bytes(format, Encoding::Raw, &image).len();
            let encoding = Encoding::Raw;
            let picture = Picture { image: &image, format, encoding, recipe: "{}", crop: None };
            for size in [0, 1, 100, 1000, whole / 3, whole / 2, whole - 60] {
                for error in ERRORS {
                    let mut disk = SmallDisk { file: io::Cursor::default(), size, error };
                    let said = picture.write(&mut disk).unwrap_err();
                    assert_eq!(said.raw_os_error(), Some(error), "{format:?} of {size}: {said}");
                }
            }
        }
    }

    #[test]
    fn values_that_are_not_finite_are_counted() {
        let image = sample_image();
        let picture = Picture {
            image: &image,
            format: OutputFormat::Png8,
            encoding: Encoding::Raw,
            recipe: "",
            crop: None,
        };
        assert_eq!(picture.not_finite(), 1);
    }

    #[test]
    fn a_picture_without_pixels_is_an_error() {
        let image = Image { width: 0, height: 4, rgb: Vec::new() };
        for format in [OutputFormat::Png8, OutputFormat::Exr] {
            let encoding = Encoding::Raw;
            let picture = Picture { image: &image, format, encoding, recipe: "", crop: None };
            assert!(picture.write(io::Cursor::new(Vec::new())).is_err(), "{format:?}");
        }
    }
}
