//! What the program asks of a kind of file, such as PNG or EXR.

use std::fmt::{self, Display};
use std::io::{self, BufRead, Read, Seek, Write};

use slo_scene::OutputFormat;

use super::claim::ReadError;
use super::picture::Picture;
use super::raster::Raster;
use crate::film::{FileLayer, Image, Pixels};

/// Keyword of the text that holds the recipe: a PNG text chunk, an EXR attribute.
pub const KEYWORD: &str = "slo-rt recipe";

/// A file that is read.
pub(super) trait Source: BufRead + Seek {}
impl<T: BufRead + Seek> Source for T {}

/// A file that is written, and may be read again meanwhile.
pub(super) trait Sink: Read + Write + Seek {}
impl<T: Read + Write + Seek> Sink for T {}

/// A kind of file: how pictures get into it and out of it.
pub(super) trait Container: Sync {
    /// The first bytes of every such file.
    fn magic(&self) -> &'static [u8];

    /// Writes a picture, its recipe, and layers of the same size if the format has layers, to an
    /// empty file. The bytes depend on nothing else.
    fn write(
        &self,
        picture: &Picture,
        layers: &[(&FileLayer, &dyn Pixels)],
        out: &mut dyn Sink,
    ) -> io::Result<()>;

    /// Bytes of memory to write a picture of this size with so many images, itself and its layers.
    fn memory(&self, size: [u32; 2], images: u64) -> u64;

    /// Reads the colours, whoever wrote the file. Refuses a file of ours that is damaged.
    fn read(&self, input: &mut dyn Source) -> Result<Raster, ReadError>;

    /// Reads the layers beside the colours, in the order of [`FileLayer::all`].
    fn read_layers(&self, input: &mut dyn Source) -> Result<Vec<(FileLayer, Image)>, ReadError>;

    /// The number of pixels in the header; `None` if it can't be read.
    fn claimed_pixels(&self, input: &mut dyn Source) -> Option<u64>;

    /// Reads the recipe. Reads all of the file, and checks its checksums.
    fn recipe(&self, input: &mut dyn Source) -> Result<(String, Wholeness), RecipeError>;

    /// Whether a whole file with this beginning is cut off before its first pixel.
    fn ends_before_pixels(&self, whole: &[u8]) -> bool;

    /// Whether a damaged file may look like a sound one without a recipe.
    fn may_lose_recipe(&self) -> bool;
}

/// Whether a file with a recipe is the file that was written with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::output) enum Wholeness {
    /// It is.
    Whole,
    /// Another program has read it, kept the recipe and written a file of its own.
    Resaved,
}

/// Why a file's recipe can't be read.
#[derive(Debug)]
pub enum RecipeError {
    /// The file can't be read.
    Io(io::Error),
    /// It has none of our formats: what its reader says.
    NotAPicture(String),
    /// It differs from the file that was written: what is damaged.
    Damaged(String),
    /// A sound file that holds no recipe.
    NoRecipe,
}

impl Display for RecipeError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Io(error) => write!(f, "{error}"),
            Self::NotAPicture(why) => {
                write!(f, "not a {} picture: {why}", OutputFormat::kinds())
            }
            Self::Damaged(why) => f.write_str(why),
            Self::NoRecipe => write!(f, "the picture holds no recipe of slo-rt"),
        }
    }
}

impl std::error::Error for RecipeError {}
