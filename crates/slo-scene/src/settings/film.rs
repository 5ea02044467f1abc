//! The `Film` element.

use super::entry::{Effect, choice, count, entries, optional_choice, single, text};
use super::format::OutputFormat;
use super::list::Settings;
use super::value::Bound;
use super::words::{Encoding, Layer, ToneMap};

/// Longest side of a picture, in pixels.
pub const MOST_PIXELS: u32 = 65_536;

entries! {
    /// The `Film` element.
    #[derive(Clone, Debug, PartialEq)]
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
        /// Transfer curve of encoded values; `None`: the curve that goes with the settings, see
        /// [`look`](Film::look).
        encoding: Option<Encoding> = None, optional_choice("encoding", Effect::Display);
        /// Doublings of the light before it is encoded.
        exposure: f32 = 0.0, single("exposure", Bound::Stops, Effect::Display).unless_default();
        /// What becomes of light that is brighter than white.
        tone_map: ToneMap = ToneMap::None, choice("toneMap", Effect::Display).unless_default();
    }
    beside {
        /// What a file holds beside the colours; ascending, each once. The command line asks for them.
        layers: Vec<Layer> = Vec::new();
    }
}

/// How radiance becomes the values of a file that a screen shows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Look {
    /// Doublings of the light, applied first.
    pub exposure: f32,
    /// Compresses the exposed light into the range of a screen.
    pub tone_map: ToneMap,
    /// The transfer curve, applied last.
    pub encoding: Encoding,
}

impl Look {
    /// A transfer curve alone.
    pub const fn of(encoding: Encoding) -> Self {
        Self { exposure: 0.0, tone_map: ToneMap::None, encoding }
    }
}

impl Film {
    /// How the film shows radiance if the scene has these settings.
    pub fn look(&self, settings: &Settings) -> Look {
        let encoding = self.encoding.unwrap_or(settings.encoding());
        Look { exposure: self.exposure, tone_map: self.tone_map, encoding }
    }
}
