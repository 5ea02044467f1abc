//! Values of options, and how they are typed.

use std::fmt;

use clap::ValueEnum;
use clap::builder::PossibleValue;

use super::numbers::{count, real, whole};
use crate::cli::sequence::Frames;
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
    let expected =
        || "expected width x height + column + row in pixels, such as 320x180+0+90".to_owned();
    let (sides, place) = text.split_once('+').ok_or_else(expected)?;
    let Size { width, height } = pixels(sides).ok_or_else(expected)?;
    let (x, y) = place.split_once('+').ok_or_else(expected)?;
    let number = |text| whole(text).and_then(|number| u32::try_from(number).ok());
    match (number(x), number(y)) {
        (Some(x), Some(y)) => Ok(Region { width, height, x, y }),
        _ => Err(expected()),
    }
}

/// Parses an error.
pub(super) fn noise(text: &str) -> Result<f32, String> {
    let error = real(text).filter(|error| *error > 0.0 && *error <= 1.0);
    match error.map(|error| error as f32) {
        Some(0.0) => Err("it is too close to 0; 0.01 is a usual error".into()),
        error => error
            .ok_or_else(|| "expected an error above 0 and at most 1, such as 0.01 or 1%".into()),
    }
}

/// Parses a distance that is allowed.
pub(super) fn limit(text: &str) -> Result<f64, String> {
    let limit = real(text).filter(|limit| *limit >= 0.0);
    limit.ok_or_else(|| "expected a limit of 0 or more, such as 0.01 or 1%".into())
}

/// Parses `STEP,TILES`, also as a recipe has it, in brackets.
pub(super) fn steps(text: &str) -> Result<Steps, String> {
    let inside = text.trim().strip_prefix('[').and_then(|text| text.strip_suffix(']'));
    let number = |text| whole(text).and_then(|number| u32::try_from(number).ok());
    let numbers = inside
        .unwrap_or(text)
        .split_once(',')
        .and_then(|(step, tiles)| Some((number(step)?, number(tiles)?)));
    match numbers {
        Some((done, tiles)) if done <= Steps::LAST => Ok(Steps { done, tiles }),
        _ => Err(format!(
            "expected a step up to {} and a number of tiles, such as 7,120",
            Steps::LAST
        )),
    }
}

/// Parses `K/N`, also as names of files have it: `K-of-N`.
pub(super) fn part(text: &str) -> Result<Part, String> {
    let number = |text| whole(text).and_then(|number| u32::try_from(number).ok());
    let numbers = text.split_once('/').or_else(|| text.split_once("-of-"));
    let numbers = numbers.and_then(|(k, n)| Some((number(k)?, number(n)?)));
    match numbers {
        Some((number, of)) if (1..=of).contains(&number) => Ok(Part { number, of }),
        _ => Err("expected a number and how many parts there are, such as 3/10".into()),
    }
}

/// Parses a number of samples.
pub(super) fn samples(text: &str) -> Result<u32, String> {
    count(text, 1..=65_535, "64")
}

/// Parses a seed.
pub(super) fn seed(text: &str) -> Result<u64, String> {
    count(text, 0..=u64::MAX, "7")
}

/// `--threads`
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::cli) enum Threads {
    /// As many as the machine has processors, whatever the scene says.
    All,
    Count(u32),
}

/// Parses a number of threads.
pub(super) fn threads(text: &str) -> Result<Threads, String> {
    if ["auto", "all"].iter().any(|word| text.trim().eq_ignore_ascii_case(word)) {
        return Ok(Threads::All);
    }
    let count = count(text, 1..=4096, "4").map(Threads::Count);
    count.map_err(|expected| format!("{expected}, or `auto` for all of the machine"))
}

/// `--frame`
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::cli) enum FrameChoice {
    /// All that the scene has.
    All,
    These(Frames),
}

impl FrameChoice {
    /// Whether a range or a list was asked for, even if one frame is in it.
    pub(in crate::cli) fn is_sequence(&self) -> bool {
        match self {
            Self::All => true,
            Self::These(frames) => frames.is_sequence,
        }
    }

    /// Whether more than one frame may be in it.
    pub(in crate::cli) fn is_several(&self) -> bool {
        match self {
            Self::All => true,
            Self::These(frames) => frames.numbers.len() > 1,
        }
    }
}

/// Parses frames, or `all`.
pub(super) fn frames(text: &str) -> Result<FrameChoice, String> {
    match text.trim().eq_ignore_ascii_case("all") {
        true => Ok(FrameChoice::All),
        false => Frames::parse(text).map(FrameChoice::These),
    }
}

/// `--size`, in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::cli) struct Size {
    pub(in crate::cli) width: u32,
    pub(in crate::cli) height: u32,
}

/// `--size`, as typed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::cli) enum SizeChoice {
    Pixels(Size),
    /// Of each side of the scene's picture.
    Share(f64),
}

impl SizeChoice {
    /// The size where the scene's picture has `width` x `height` pixels.
    pub(in crate::cli) fn of(self, width: u32, height: u32) -> Size {
        match self {
            Self::Pixels(size) => size,
            Self::Share(share) => {
                let side = |side: u32| {
                    (f64::from(side) * share).round().clamp(1.0, f64::from(LARGEST_SIDE)) as u32
                };
                Size { width: side(width), height: side(height) }
            }
        }
    }
}

/// `--layers`
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::cli) struct LayerName(Layer);

impl ValueEnum for LayerName {
    fn value_variants<'a>() -> &'a [Self] {
        const ALL: [LayerName; Layer::ALL.len()] = {
            let mut all = [LayerName(Layer::ALL[0]); Layer::ALL.len()];
            let mut i = 0;
            while i < all.len() {
                all[i] = LayerName(Layer::ALL[i]);
                i += 1;
            }
            all
        };
        &ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.0.name()))
    }
}

impl From<LayerName> for Layer {
    fn from(name: LayerName) -> Self {
        name.0
    }
}

/// `--format`
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::cli) struct FormatName(OutputFormat);

impl ValueEnum for FormatName {
    fn value_variants<'a>() -> &'a [Self] {
        const ALL: [FormatName; OutputFormat::ALL.len()] = {
            let mut all = [FormatName(OutputFormat::ALL[0]); OutputFormat::ALL.len()];
            let mut i = 0;
            while i < all.len() {
                all[i] = FormatName(OutputFormat::ALL[i]);
                i += 1;
            }
            all
        };
        &ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.0.option()).aliases(self.0.aliases()))
    }
}

impl From<FormatName> for OutputFormat {
    fn from(name: FormatName) -> Self {
        name.0
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

const LARGEST_SIDE: u32 = 65_536;

/// Sizes with names.
const NAMED: [(&str, [u32; 2]); 7] = [
    ("720p", [1280, 720]),
    ("1080p", [1920, 1080]),
    ("1440p", [2560, 1440]),
    ("2160p", [3840, 2160]),
    ("4k", [3840, 2160]),
    ("4320p", [7680, 4320]),
    ("8k", [7680, 4320]),
];

/// Parses `WxH`, a name, or a share.
pub(super) fn size(text: &str) -> Result<SizeChoice, String> {
    let text = text.trim();
    if let Some((_, [width, height])) =
        NAMED.into_iter().find(|(name, _)| name.eq_ignore_ascii_case(text))
    {
        return Ok(SizeChoice::Pixels(Size { width, height }));
    }
    let share =
        || real(text).filter(|share| text.ends_with('%') && *share > 0.0 && *share <= 100.0);
    let found = pixels(text).map(SizeChoice::Pixels).or_else(|| share().map(SizeChoice::Share));
    found.ok_or_else(|| {
        format!(
            "expected width x height in pixels, each from 1 to {LARGEST_SIDE}, such as 320x180, \
             a size with a name, such as 1080p or 4k, or a share of the scene's, such as 50%"
        )
    })
}

/// Parses `WxH`.
fn pixels(text: &str) -> Option<Size> {
    let (width, height) = text.split_once(['x', 'X', '×'])?;
    let side = |text: &str| whole(text).and_then(|side| u32::try_from(side).ok());
    let side = |text: &str| side(text).filter(|side| (1..=LARGEST_SIDE).contains(side));
    Some(Size { width: side(width)?, height: side(height)? })
}
