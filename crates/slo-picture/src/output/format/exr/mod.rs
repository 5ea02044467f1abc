//! OpenEXR.

mod claim;
mod header;
mod order;
mod read;
mod seal;
mod write;

use std::io;

use super::claim::ReadError;
use super::container::{Container, RecipeError, Sink, Source, Wholeness};
use super::picture::Picture;
use super::raster::Raster;
use crate::film::{FileLayer, Image, Pixels};

/// The first bytes of every EXR file.
const MAGIC: &[u8] = b"\x76\x2f\x31\x01";

/// EXR files.
#[derive(Debug)]
pub(super) struct Exr;

impl Container for Exr {
    fn magic(&self) -> &'static [u8] {
        MAGIC
    }

    fn write(
        &self,
        picture: &Picture,
        layers: &[(&FileLayer, &dyn Pixels)],
        out: &mut dyn Sink,
    ) -> io::Result<()> {
        write::write(picture, layers, out)
    }

    /// Colours are written as they are computed; channels beside them need arrays.
    fn memory(&self, [width, height]: [u32; 2], images: u64) -> u64 {
        let pixels = u64::from(width) * u64::from(height);
        if images > 1 { pixels.saturating_mul(12 * images) } else { 0 }
    }

    fn read(&self, input: &mut dyn Source) -> Result<Raster, ReadError> {
        read::read(input)
    }

    fn read_layers(&self, input: &mut dyn Source) -> Result<Vec<(FileLayer, Image)>, ReadError> {
        read::read_layers(input)
    }

    fn claimed_pixels(&self, input: &mut dyn Source) -> Option<u64> {
        read::claimed_pixels(input)
    }

    fn recipe(&self, input: &mut dyn Source) -> Result<(String, Wholeness), RecipeError> {
        read::recipe(input)
    }

    fn ends_before_pixels(&self, whole: &[u8]) -> bool {
        MAGIC.starts_with(whole) || whole.starts_with(MAGIC) && seal::ends_in_header(whole)
    }

    /// The name of the attribute may be damaged, and the name of the seal too.
    fn may_lose_recipe(&self) -> bool {
        true
    }
}
