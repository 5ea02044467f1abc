//! The `Film` element.

use super::entry::{Effect, choice, count, entries, text};
use super::format::OutputFormat;
use super::words::{Encoding, Layer};

/// Longest side of a picture, in pixels.
pub const MOST_PIXELS: u32 = 65_536;

entries! {
    /// The `Film` element.
    #[derive(Clone, Debug, PartialEq, Eq)]
    #[non_exhaustive]
    pub struct Film {
        /// Pixels in a row.
        width: u32 = 1, count("width", [1, MOST_PIXELS], Effect::Samples).required();
        /// Rows.
        height: u32 = 1, count("height", [1, MOST_PIXELS], Effect::Samples).required();
        /// In front of the frame number in the file's name.
        prefix: String = "frame_".to_owned(), text("prefix", "TEXT", Effect::Nothing);
        /// File format.
        output: OutputFormat = OutputFormat::Png8, choice("output", Effect::Display);
        /// Transfer curve of encoded values.
        encoding: Encoding = Encoding::Raw, choice("encoding", Effect::Display);
    }
    beside {
        /// What a file holds beside the colours; ascending, each once. The command line asks for them.
        layers: Vec<Layer> = Vec::new();
    }
}
