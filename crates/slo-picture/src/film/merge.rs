//! Films of parts -> the film of the whole picture.

use std::ops::Range;

use super::area::Area;
use super::grid::Film;
use super::memory::TooLarge;
use super::state::{State, Subject};

/// Why parts do not make a whole picture. Parts are named by the index with which they were added.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MergeError {
    /// Pixels whose samples the parts do not have, or not all.
    Gap {
        /// How many.
        pixels: usize,
        /// Column and row of the first.
        first: (u32, u32),
        /// Missing samples of that pixel; `None`: all.
        samples: Option<Range<u32>>,
    },
    /// Two parts have the same samples of a pixel.
    Overlap {
        /// The parts.
        parts: [usize; 2],
        /// Column and row.
        at: (u32, u32),
    },
    /// Sums that no picture can reach.
    TooBright,
    /// There is not enough memory.
    TooLarge(TooLarge),
}

impl From<TooLarge> for MergeError {
    fn from(error: TooLarge) -> Self {
        Self::TooLarge(error)
    }
}

/// Adds up the parts of one picture. The sums do not depend on how it was parted, nor on the order.
#[derive(Debug)]
pub struct Merger {
    film: Film,
    /// Samples of a pixel, if they are shared out.
    all: u32,
    /// One for each share of the samples.
    shares: Vec<Share>,
}

/// Which part has which pixel.
#[derive(Debug)]
struct Share {
    samples: Range<u32>,
    /// Number of the part from 1 on, 0 for none.
    owners: Vec<u32>,
}

impl Merger {
    /// For the picture, or the region, of `subject`, with `all` samples per pixel if parts have a share
    /// of them.
    ///
    /// # Errors
    /// [`TooLarge`] if there is not enough memory.
    pub fn new(subject: &Subject, all: u32) -> Result<Self, TooLarge> {
        let film = subject.film_of(subject.region)?;
        Ok(Self { film, all, shares: Vec::new() })
    }

    /// Adds part number `index`.
    ///
    /// # Errors
    /// Another part has the same samples of the same pixels.
    pub fn add(&mut self, index: usize, state: &State) -> Result<(), MergeError> {
        let area = self.film.area().common(&state.subject.region);
        let samples = state.subject.samples.clone().unwrap_or(0..self.all);
        let share = self.share(samples)?;
        let own = self.film.area();
        let cells = (area.y0..area.y1).flat_map(|y| (area.x0..area.x1).map(move |x| (x, y)));
        for at in cells {
            let (from, to) = (place(state.film.area(), at), place(own, at));
            if state.film.pixels()[from].samples == 0 {
                continue;
            }
            let owner = &mut self.shares[share].owners[to];
            if *owner > 0 {
                return Err(MergeError::Overlap { parts: [*owner as usize - 1, index], at });
            }
            *owner = index as u32 + 1;
            self.add_pixel(to, state, from)?;
        }
        Ok(())
    }

    fn add_pixel(&mut self, to: usize, state: &State, from: usize) -> Result<(), MergeError> {
        let (pixel, spread) = self.film.at_mut(to);
        *pixel = pixel.checked_add(&state.film.pixels()[from]).ok_or(MergeError::TooBright)?;
        if let (Some(spread), Some(more)) = (spread, state.film.spreads().get(from)) {
            spread.unite(more);
        }
        if let (Some(sum), Some(more)) =
            (self.film.features_mut(to), state.film.features().get(from))
        {
            *sum = sum.checked_add(more).ok_or(MergeError::TooBright)?;
        }
        for (sum, more) in self.film.lights_mut(to).iter_mut().zip(state.film.lights(from)) {
            sum.iter_mut().zip(more).for_each(|(sum, more)| *sum += *more);
        }
        let added = self.film.first_hits_mut().checked_add(to, state.film.first_hits(), from);
        added.ok_or(MergeError::TooBright)
    }

    /// Index of a share of the samples.
    fn share(&mut self, samples: Range<u32>) -> Result<usize, MergeError> {
        if let Some(found) = self.shares.iter().position(|share| share.samples == samples) {
            return Ok(found);
        }
        let pixels = self.film.pixels().len();
        let bytes = pixels as u64 * 4;
        let mut owners = Vec::new();
        owners.try_reserve_exact(pixels).map_err(|_| TooLarge { bytes })?;
        owners.resize(pixels, 0);
        self.shares.push(Share { samples, owners });
        Ok(self.shares.len() - 1)
    }

    /// Returns the film of the whole picture.
    ///
    /// # Errors
    /// Some samples are in no part, or in several.
    pub fn finish(mut self) -> Result<Film, MergeError> {
        self.shares.sort_by_key(|share| (share.samples.start, share.samples.end));
        let area = self.film.area();
        let (mut pixels, mut first) = (0, None);
        for i in 0..area.len() {
            let at = (area.x0 + i as u32 % area.width(), area.y0 + i as u32 / area.width());
            if let Some(missing) = self.missing(i, at)? {
                pixels += 1;
                first.get_or_insert((at, missing));
            }
        }
        match first {
            None => Ok(self.film),
            Some((first, missing)) => {
                let samples = Some(missing).filter(|range| *range != (0..self.all));
                Err(MergeError::Gap { pixels, first, samples })
            }
        }
    }

    /// The first missing samples of a pixel.
    fn missing(&self, pixel: usize, at: (u32, u32)) -> Result<Option<Range<u32>>, MergeError> {
        let (mut end, mut before) = (0, 0);
        for Share { samples, owners } in &self.shares {
            let owner = owners[pixel] as usize;
            if owner == 0 {
                continue;
            }
            if samples.start > end {
                return Ok(Some(end..samples.start));
            }
            if samples.start < end {
                return Err(MergeError::Overlap { parts: [before, owner - 1], at });
            }
            (end, before) = (samples.end, owner - 1);
        }
        Ok((end < self.all).then_some(end..self.all))
    }
}

fn place(area: Area, (x, y): (u32, u32)) -> usize {
    (y - area.y0) as usize * area.width() as usize + (x - area.x0) as usize
}

#[cfg(test)]
mod tests {
    use slo_scene::{LightGroups, MaskNames};

    use super::super::first_hits::{FirstHitLayers, PlaceLayers};
    use super::super::fixed::{Fixed, SignedFixed};
    use super::super::mask::MaskKind;
    use super::super::wide::Wide;
    use super::*;

    fn layers() -> FirstHitLayers {
        let places = PlaceLayers { depth: true, uv: true, ..PlaceLayers::default() };
        let materials = Some(MaskNames::new(["steel"]));
        FirstHitLayers { places, materials, ..FirstHitLayers::default() }
    }

    fn state(region: Area, samples: Option<Range<u32>>) -> State {
        let area = region.in_blocks(&Area::whole(20, 20));
        let recipe = String::new();
        let subject = Subject {
            recipe,
            area,
            region,
            samples: samples.clone(),
            with_spreads: false,
            with_features: true,
            light_groups: Some(LightGroups::new(["key"])),
            first_hits: layers(),
        };
        let mut film = subject.film().unwrap();
        for i in 0..area.len() {
            let count = samples.clone().map_or(4, |range| range.len() as u32);
            let sum = [Fixed::new(count as f32).unwrap(); 3];
            film.at_mut(i).0.add_later(sum, count);
            film.features_mut(i).unwrap().normal = [SignedFixed::clamped(count as f32); 3];
            film.lights_mut(i)[0] = sum;
            let hits = film.first_hits_mut();
            hits.places_mut(i).fill(Wide::clamped(count.into()));
            hits.ids_mut(MaskKind::Material, i).unwrap().add(7, count).unwrap();
        }
        State { subject, film, is_complete: true }
    }

    fn merged(parts: &[State]) -> Result<Film, MergeError> {
        let whole = state(Area::whole(20, 20), None);
        let mut merger = Merger::new(&whole.subject, 4)?;
        for (i, part) in parts.iter().enumerate() {
            merger.add(i, part)?;
        }
        merger.finish()
    }

    const LEFT: Area = Area { x0: 0, y0: 0, x1: 9, y1: 20 };
    const RIGHT: Area = Area { x0: 9, y0: 0, x1: 20, y1: 20 };

    #[test]
    fn regions_make_a_whole_although_their_blocks_overlap() {
        let whole = state(Area::whole(20, 20), None).film;
        assert_eq!(merged(&[state(RIGHT, None), state(LEFT, None)]), Ok(whole));
    }

    #[test]
    fn samples_make_a_whole() {
        let whole = Area::whole(20, 20);
        let film = merged(&[state(whole, Some(1..4)), state(whole, Some(0..1))]).unwrap();
        assert!(film.sample_counts().iter().all(|&n| n == 4));
        let mixed = [state(LEFT, Some(1..4)), state(whole, Some(0..1)), state(RIGHT, Some(1..4))];
        assert_eq!(merged(&mixed), Ok(film));
    }

    #[test]
    fn gaps_and_overlaps_are_refused() {
        let whole = Area::whole(20, 20);
        let gap = MergeError::Gap { pixels: 180, first: (0, 0), samples: None };
        assert_eq!(merged(&[state(RIGHT, None)]), Err(gap));
        let overlap = MergeError::Overlap { parts: [0, 1], at: (0, 0) };
        assert_eq!(merged(&[state(whole, None), state(LEFT, None)]), Err(overlap));
        let gap =
            |first, pixels, samples| Err(MergeError::Gap { pixels, first, samples: Some(samples) });
        let samples = [state(whole, Some(0..1)), state(whole, Some(2..4))];
        assert_eq!(merged(&samples), gap((0, 0), 400, 1..2));
        let samples = [state(whole, Some(2..4)), state(whole, Some(0..3))];
        let overlap = MergeError::Overlap { parts: [1, 0], at: (0, 0) };
        assert_eq!(merged(&samples), Err(overlap));
        assert_eq!(merged(&samples[1..]), gap((0, 0), 400, 3..4));
        let half = [state(whole, Some(0..2)), state(LEFT, Some(2..4))];
        assert_eq!(merged(&half), gap((9, 0), 220, 2..4));
        let mixed = [state(LEFT, None), state(RIGHT, Some(0..2)), state(RIGHT, Some(2..4))];
        assert!(merged(&mixed).is_ok());
        assert!(matches!(merged(&[]), Err(MergeError::Gap { pixels: 400, .. })));
    }
}
