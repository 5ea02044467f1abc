//! A picture that is to become a file.

use slo_scene::{Look, OutputFormat};

use crate::film::{Area, Pixels};

/// An image with all that decides its file's bytes.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    /// Linear radiance.
    pub image: &'a dyn Pixels,
    /// File format.
    pub format: OutputFormat,
    /// How radiance becomes encoded values; formats with linear values ignore it.
    pub look: Look,
    /// The recipe as JSON, ASCII only; see [`Recipe::to_json`](crate::output::Recipe::to_json).
    pub recipe: &'a str,
    /// Where it lies in a larger picture, for formats that hold that; `None`: it is all of it.
    pub crop: Option<Crop>,
}

impl Picture<'_> {
    /// Counts the pixels with a channel that is not a finite number; files hold 0 for such a channel.
    pub fn not_finite(&self) -> usize {
        let [width, height] = self.image.size();
        let is_odd = |x: u32, y: u32| !self.image.at(x, y).iter().all(|c| c.is_finite());
        (0..height).map(|y| (0..width).filter(|&x| is_odd(x, y)).count()).sum()
    }
}

/// Some pixels of a larger picture: in an EXR file its data window and its display window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop {
    /// The pixels that are there.
    pub area: Area,
    /// The picture.
    pub whole: Area,
}

impl Crop {
    /// Some pixels of a picture; `None` if they are all of it.
    pub fn of(area: Area, whole: Area) -> Option<Self> {
        (area != whole && whole.holds(&area)).then_some(Self { area, whole })
    }
}
