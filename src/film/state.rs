//! What a run knows of a picture, so that another run can go on from it.

use std::ops::Range;

use super::{Area, Film, TooLarge};

/// What a film is exposed for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Subject {
    /// The recipe of the picture, as JSON.
    pub recipe: String,
    /// The whole blocks around [`region`](Self::region).
    pub area: Area,
    /// The area that was asked for.
    pub region: Area,
    /// Where the samples of a pixel are shared out: the numbers of those of this share. The film's
    /// `base` then holds those below the [`base_end`](super::base_end) of all of them.
    pub samples: Option<Range<u32>>,
    /// Whether the smallest and largest sample of a pixel count.
    pub with_spreads: bool,
}

impl Subject {
    /// An unexposed film for it.
    ///
    /// # Errors
    /// [`TooLarge`] where memory does not suffice.
    pub fn film(&self) -> Result<Film, TooLarge> {
        Film::new(self.area, self.with_spreads)
    }

    /// Whether films of both show the same samples of the same pixels, the recipes aside.
    pub fn same_place(&self, other: &Self) -> bool {
        let place = |s: &Self| (s.area, s.region, s.samples.clone(), s.with_spreads);
        place(self) == place(other)
    }
}

/// A film with all that is needed to go on exposing it: a checkpoint, a part, a finished picture
/// that may get more samples.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct State {
    /// What the film is exposed for.
    pub subject: Subject,
    /// What is known.
    pub film: Film,
    /// Whether all that was asked for is in it.
    pub is_complete: bool,
}
