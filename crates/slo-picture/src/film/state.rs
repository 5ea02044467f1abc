//! What a run knows of a picture, so that another run can go on from it.

use std::ops::Range;

use super::area::Area;
use super::grid::{Film, TooLarge};

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
    /// Whether what is seen of surfaces counts.
    pub with_features: bool,
}

impl Subject {
    /// An unexposed film for it.
    ///
    /// # Errors
    /// [`TooLarge`] where memory does not suffice.
    pub fn film(&self) -> Result<Film, TooLarge> {
        self.film_of(self.area)
    }

    /// The same of another area.
    pub(super) fn film_of(&self, area: Area) -> Result<Film, TooLarge> {
        let film = Film::new(area, self.with_spreads)?;
        if self.with_features { film.with_features() } else { Ok(film) }
    }

    /// Whether films of both show the same samples of the same pixels, the recipes aside.
    pub fn same_place(&self, other: &Self) -> bool {
        let known = |s: &Self| (s.with_spreads, s.with_features);
        let place = |s: &Self| (s.area, s.region, s.samples.clone(), known(s));
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
