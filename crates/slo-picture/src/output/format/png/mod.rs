//! PNG.

mod chunks;
mod read;
mod write;

use std::io;

use super::claim::ReadError;
use super::container::{Container, RecipeError, Sink, Source, Wholeness};
use super::picture::Picture;
use super::raster::Raster;
use crate::film::{FileLayer, Image, Pixels};
pub(super) use write::Depth;

/// PNG files; those that are written have values of this depth.
#[derive(Debug)]
pub(super) struct Png(pub(super) Depth);

impl Container for Png {
    fn magic(&self) -> &'static [u8] {
        &chunks::SIGNATURE[..4]
    }

    fn write(
        &self,
        picture: &Picture,
        _layers: &[(&FileLayer, &dyn Pixels)],
        out: &mut dyn Sink,
    ) -> io::Result<()> {
        write::write(picture, self.0, out)
    }

    /// Some rows are encoded at a time.
    fn memory(&self, size: [u32; 2], _images: u64) -> u64 {
        write::memory(size, self.0)
    }

    fn read(&self, input: &mut dyn Source) -> Result<Raster, ReadError> {
        read::read(input)
    }

    fn read_layers(&self, _input: &mut dyn Source) -> Result<Vec<(FileLayer, Image)>, ReadError> {
        Ok(Vec::new())
    }

    fn claimed_pixels(&self, input: &mut dyn Source) -> Option<u64> {
        read::claimed_pixels(input)
    }

    fn recipe(&self, input: &mut dyn Source) -> Result<(String, Wholeness), RecipeError> {
        read::recipe(input)
    }

    fn ends_before_pixels(&self, whole: &[u8]) -> bool {
        chunks::SIGNATURE.starts_with(whole)
            || whole.starts_with(&chunks::SIGNATURE) && !whole.windows(4).any(|at| at == b"IDAT")
    }

    /// Every chunk has a checksum.
    fn may_lose_recipe(&self) -> bool {
        false
    }
}
