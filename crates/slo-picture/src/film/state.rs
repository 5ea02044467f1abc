//! What another run needs to continue a picture.

use std::ops::Range;

use slo_scene::LightGroups;

use super::area::Area;
use super::first_hits::FirstHitLayers;
use super::grid::Film;
use super::memory::TooLarge;

/// What a film is exposed for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Subject {
    /// The recipe of the picture, as JSON.
    pub recipe: String,
    /// The whole blocks around [`region`](Self::region).
    pub area: Area,
    /// The area that was asked for.
    pub region: Area,
    /// If the samples of a pixel are shared out: the numbers of this share's samples. The film's `base`
    /// then holds the samples below the [`base_end`](super::base_end) of all of them.
    pub samples: Option<Range<u32>>,
    /// Whether the film records the smallest and largest sample of a pixel.
    pub with_spreads: bool,
    /// Whether the film has layers of surfaces.
    pub with_features: bool,
    /// The groups of lights whose light the film keeps apart, if it does.
    pub light_groups: Option<LightGroups>,
    /// The layers of what camera rays hit first.
    pub first_hits: FirstHitLayers,
}

impl Subject {
    /// Returns an unexposed film for it.
    ///
    /// # Errors
    /// [`TooLarge`] if there is not enough memory.
    pub fn film(&self) -> Result<Film, TooLarge> {
        self.film_of(self.area)
    }

    /// The same of another area.
    pub(super) fn film_of(&self, area: Area) -> Result<Film, TooLarge> {
        let film = Film::new(area, self.with_spreads)?;
        let film = if self.with_features { film.with_features()? } else { film };
        let film = match &self.light_groups {
            Some(groups) => film.with_light_groups(groups.clone())?,
            None => film,
        };
        film.with_first_hits(self.first_hits.clone())
    }

    /// Whether films of both show the same samples of the same pixels, the recipes aside.
    pub fn same_place(&self, other: &Self) -> bool {
        let place = |s: &Self| (s.area, s.region, s.samples.clone(), s.with_spreads);
        place(self) == place(other) && self.same_layers(other)
    }

    /// Whether films of both have the same layers.
    pub fn same_layers(&self, other: &Self) -> bool {
        let layers = |s: &Self| (s.with_features, s.light_groups.clone(), s.first_hits.clone());
        layers(self) == layers(other)
    }
}

/// A film with all that is needed to expose it further: a checkpoint, a part, a finished picture that
/// may get more samples.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct State {
    /// What the film is exposed for.
    pub subject: Subject,
    /// The sums so far.
    pub film: Film,
    /// Whether it holds all samples that were asked for.
    pub is_complete: bool,
}
