//! Values of options, and how they are typed.

use std::fmt;

use clap::ValueEnum;

use crate::film::Layer;
use crate::render::{Part, Steps};
use crate::scene::{Accelerator, OutputFormat};

/// `--region`, in pixels from the upper left corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::cli) struct Region {
    pub(in crate::cli) width: u32,
    pub(in crate::cli) height: u32,
    pub(in crate::cli) x: u32,
    pub(in crate::cli) y: u32,
}

impl fmt::Display for Region {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}+{}+{}", self.width, self.height, self.x, self.y)
    }
}

/// `--part-by`
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum PartBy {
    #[default]
    Pixels,
    Samples,
}

impl PartBy {
    /// As in names of files.
    pub(in crate::cli) fn word(self) -> &'static str {
        match self {
            Self::Pixels => "pixels",
            Self::Samples => "samples",
        }
    }
}

/// Parses `WxH+X+Y`.
pub(super) fn region(text: &str) -> Result<Region, String> {
    let expected = || "expected width x height + column + row, such as 320x180+0+90".to_owned();
    let (sides, place) = text.split_once('+').ok_or_else(expected)?;
    let Size { width, height } = size(sides)?;
    let (x, y) = place.split_once('+').ok_or_else(expected)?;
    match (x.parse(), y.parse()) {
        (Ok(x), Ok(y)) => Ok(Region { width, height, x, y }),
        _ => Err(expected()),
    }
}

/// Parses an error.
pub(super) fn noise(text: &str) -> Result<f32, String> {
    let error = text.parse().ok().filter(|error: &f64| *error > 0.0 && *error <= 1.0);
    match error.map(|error| error as f32) {
        Some(0.0) => Err("it is too close to 0".into()),
        error => error.ok_or_else(|| "an error is more than 0 and at most 1, such as 0.01".into()),
    }
}

/// Parses a distance that is allowed.
pub(super) fn limit(text: &str) -> Result<f64, String> {
    let limit = text.parse().ok().filter(|limit: &f64| limit.is_finite() && *limit >= 0.0);
    limit.ok_or_else(|| "a limit is 0 or more, such as 0.01".into())
}

/// Parses `STEP,TILES`.
pub(super) fn steps(text: &str) -> Result<Steps, String> {
    let numbers = text
        .split_once(',')
        .and_then(|(step, tiles)| Some((step.trim().parse().ok()?, tiles.trim().parse().ok()?)));
    match numbers {
        Some((done, tiles)) if done <= Steps::LAST => Ok(Steps { done, tiles }),
        _ => Err(format!(
            "expected a step up to {} and a number of tiles, such as 7,120",
            Steps::LAST
        )),
    }
}

/// Parses `K/N`.
pub(super) fn part(text: &str) -> Result<Part, String> {
    let numbers = text.split_once('/').and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
    match numbers {
        Some((number, of)) if (1..=of).contains(&number) => Ok(Part { number, of }),
        _ => Err("expected a number and how many parts there are, such as 3/10".into()),
    }
}

/// `--size`, in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::cli) struct Size {
    pub(in crate::cli) width: u32,
    pub(in crate::cli) height: u32,
}

/// `--layers`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum LayerName {
    Albedo,
    Normal,
}

impl From<LayerName> for Layer {
    fn from(name: LayerName) -> Self {
        match name {
            LayerName::Albedo => Self::Albedo,
            LayerName::Normal => Self::Normal,
        }
    }
}

/// `--format`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum FormatName {
    Png,
    Png16,
    Exr,
}

impl From<FormatName> for OutputFormat {
    fn from(name: FormatName) -> Self {
        match name {
            FormatName::Png => Self::Png8,
            FormatName::Png16 => Self::Png16,
            FormatName::Exr => Self::Exr,
        }
    }
}

/// `--accelerator`, as the scene language names them.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(in crate::cli) enum AcceleratorName {
    Kdtree,
    Bvh,
    Cwbvh,
    None,
}

impl From<AcceleratorName> for Accelerator {
    fn from(name: AcceleratorName) -> Self {
        match name {
            AcceleratorName::Kdtree => Self::KdTree,
            AcceleratorName::Bvh => Self::Bvh,
            AcceleratorName::Cwbvh => Self::Cwbvh,
            AcceleratorName::None => Self::None,
        }
    }
}

/// `--color`
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum When {
    #[default]
    Auto,
    Always,
    Never,
}

/// Parses `WxH`.
pub(super) fn size(text: &str) -> Result<Size, String> {
    let side = |text: &str| text.parse().ok().filter(|side| (1..=65536).contains(side));
    let (width, height) = text
        .split_once(['x', 'X', '×'])
        .ok_or("expected width x height in pixels, such as 320x180")?;
    match (side(width), side(height)) {
        (Some(width), Some(height)) => Ok(Size { width, height }),
        _ => Err("each side is a whole number from 1 to 65536".into()),
    }
}
