//! File formats of pictures: one folder for each kind of file, and one list.
//!
//! What a format is called, and what its values are, stands in [`OutputFormat`]; how its files are
//! written and read is a [`Container`]. `container()` is the list that ties both.

mod claim;
mod container;
mod exr;
mod picture;
mod png;
mod quantise;
mod raster;
#[cfg(test)]
pub(super) mod samples;
#[cfg(test)]
mod tests;

use std::io::{self, BufRead, BufReader, Cursor, Read, Seek, Write};
use std::path::Path;

#[cfg(test)]
use slo_scene::Encoding;
use slo_scene::OutputFormat;

use super::file::{Candid, open_regular, write_atomically};
use crate::film::{FileLayer, Image, Pixels};
use container::Container;

pub use claim::ReadError;
pub(super) use container::Wholeness;
pub use container::{KEYWORD, RecipeError};
pub use picture::{Crop, Picture};
pub use raster::{Raster, Values};

/// How files of a format are written and read.
fn container(format: OutputFormat) -> &'static dyn Container {
    match format {
        OutputFormat::Png8 => &png::Png(png::Depth::Eight),
        OutputFormat::Png16 => &png::Png(png::Depth::Sixteen),
        OutputFormat::Exr => &exr::Exr,
    }
}

/// The kinds of files of all formats.
fn containers() -> impl Iterator<Item = &'static dyn Container> {
    OutputFormat::ALL.into_iter().map(container)
}

/// The kind of a file with this beginning.
fn container_of(start: &[u8]) -> Option<&'static dyn Container> {
    containers().find(|container| start.starts_with(container.magic()))
}

/// Bytes of memory to write a picture of this size with so many images, itself and its layers.
pub fn memory_to_write(format: OutputFormat, size: [u32; 2], images: u64) -> u64 {
    container(format).memory(size, images)
}

const NO_LAYERS: &[(FileLayer, Image)] = &[];

impl Picture<'_> {
    /// Writes the picture to `path`, which holds the old file or the complete new one at any time.
    ///
    /// # Errors
    /// What the system says of creating, writing or renaming; a picture without pixels.
    pub fn save(&self, path: &Path) -> io::Result<()> {
        self.save_with(path, NO_LAYERS)
    }

    /// The same, with layers of the same size; formats without layers ignore them.
    ///
    /// # Errors
    /// As [`save`](Self::save).
    pub fn save_with(&self, path: &Path, layers: &[(FileLayer, impl Pixels)]) -> io::Result<()> {
        write_atomically(path, |file| self.write_with(file, layers))
    }

    /// Writes the file's bytes to `out`, which is empty.
    ///
    /// # Errors
    /// Those of `out`; a picture without pixels.
    pub fn write(&self, out: impl Read + Write + Seek) -> io::Result<()> {
        self.write_with(out, NO_LAYERS)
    }

    /// The same, with layers of the same size; formats without layers ignore them.
    ///
    /// # Errors
    /// As [`write`](Self::write).
    pub fn write_with(
        &self,
        out: impl Read + Write + Seek,
        layers: &[(FileLayer, impl Pixels)],
    ) -> io::Result<()> {
        let layers: Vec<_> =
            layers.iter().map(|(layer, image)| (layer, image as &dyn Pixels)).collect();
        let mut out = Candid::new(out);
        let written = container(self.format).write(self, &layers, &mut out);
        out.said(written)
    }
}

impl Raster {
    /// Reads the picture at `path`.
    ///
    /// # Errors
    /// What the system says, or what is wrong with the file.
    pub fn read(path: &Path) -> Result<Self, ReadError> {
        Self::decode(BufReader::new(open_regular(path)?))
    }

    /// Reads the picture in the bytes of a file.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn from_bytes(bytes: Vec<u8>) -> Result<Self, ReadError> {
        Self::decode(Cursor::new(bytes))
    }

    fn decode(mut input: impl BufRead + Seek) -> Result<Self, ReadError> {
        match container_of(input.fill_buf()?) {
            Some(container) => container.read(&mut input),
            None => Err(ReadError::Bad(format!("not a {} picture", OutputFormat::kinds()))),
        }
    }
}

/// Reads the layers that a picture has beside its colours, in the order of [`FileLayer::all`]; none for a
/// file of another kind.
///
/// # Errors
/// What the system says, or what is wrong with the file.
pub fn read_layers(path: &Path) -> Result<Vec<(FileLayer, Image)>, ReadError> {
    let mut input = BufReader::new(open_regular(path)?);
    match container_of(input.fill_buf()?) {
        Some(container) => container.read_layers(&mut input),
        None => Ok(Vec::new()),
    }
}

/// How many pixels a picture has according to its header; 0 if that can't be read.
pub fn claimed_pixels(path: &Path) -> u64 {
    let claimed = || {
        let mut input = BufReader::new(open_regular(path).ok()?);
        container_of(input.fill_buf().ok()?)?.claimed_pixels(&mut input)
    };
    claimed().unwrap_or(0)
}

/// Reads the recipe inside the picture at `path`, as it was written. Reads all of the file, and checks
/// its checksums.
///
/// # Errors
/// See [`RecipeError`].
pub fn read_recipe(path: &Path) -> Result<String, RecipeError> {
    read_checked(path).map(|(recipe, _)| recipe)
}

/// The recipe, and what became of its file.
pub(super) fn read_checked(path: &Path) -> Result<(String, Wholeness), RecipeError> {
    let file = open_regular(path).map_err(RecipeError::Io)?;
    let mut input = BufReader::with_capacity(1 << 17, file);
    match container_of(input.fill_buf().map_err(RecipeError::Io)?) {
        Some(container) => container.recipe(&mut input),
        None => {
            let why = "its first bytes are of another kind of file";
            Err(RecipeError::NotAPicture(why.into()))
        }
    }
}

/// Whether a file is a picture that is cut off before its first pixel; `whole` is all of it.
pub(super) fn ends_before_pixels(whole: &[u8]) -> bool {
    containers().any(|container| container.ends_before_pixels(whole))
}

/// Whether damage may hide the recipe of a file with this beginning.
pub(super) fn may_lose_recipe(start: &[u8]) -> bool {
    container_of(start).is_some_and(Container::may_lose_recipe)
}
