//! Which pixels of a picture a file holds.

use crate::film::Area;

/// Some pixels of a larger picture: in an EXR file its data window and its display window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop {
    /// The pixels that are there.
    pub area: Area,
    /// The picture.
    pub whole: Area,
}

impl Crop {
    /// Some pixels of a picture; `None` where they are all of it.
    pub fn of(area: Area, whole: Area) -> Option<Self> {
        (area != whole && whole.holds(&area)).then_some(Self { area, whole })
    }
}
