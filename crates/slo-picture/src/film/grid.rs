//! The pixels of a picture and all that is known of them.

use slo_scene::LightGroups;

use super::area::Area;
use super::features::Features;
use super::first_hits::{FirstHitLayers, FirstHits};
use super::fixed::Fixed;
use super::groups::GroupSums;
use super::image::Image;
use super::memory::{TooLarge, copied, filled, filled_times};
use super::pixel::{Pixel, Spread};

/// The pixels of a picture or of a region of it, row by row, the top row first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Film {
    pub(super) area: Area,
    pub(super) pixels: Vec<Pixel>,
    /// Of each pixel; empty if no rule asks for it.
    spreads: Vec<Spread>,
    /// Of each pixel; empty if nobody asks for layers of surfaces.
    pub(super) features: Vec<Features>,
    lights: GroupSums,
    pub(super) first_hits: FirstHits,
}

impl Film {
    /// Returns an unexposed film for `area` of a picture. `with_spreads`: it records the smallest and
    /// the largest sample of each pixel too.
    ///
    /// # Errors
    /// [`TooLarge`] if there is not enough memory.
    pub fn new(area: Area, with_spreads: bool) -> Result<Self, TooLarge> {
        let pixels = filled(area)?;
        let spreads = if with_spreads { filled(area)? } else { Vec::new() };
        Ok(Self { area, pixels, spreads, ..Self::default() })
    }

    /// Adds the layers of surfaces, unexposed.
    ///
    /// # Errors
    /// [`TooLarge`] if there is not enough memory.
    pub fn with_features(self) -> Result<Self, TooLarge> {
        Ok(Self { features: filled(self.area)?, ..self })
    }

    /// Adds the light of groups of lights, unexposed.
    ///
    /// # Errors
    /// [`TooLarge`] if there is not enough memory.
    pub fn with_light_groups(self, groups: LightGroups) -> Result<Self, TooLarge> {
        let sums = filled_times(self.area, groups.len())?;
        Ok(Self { lights: GroupSums { groups: Some(groups), sums }, ..self })
    }

    /// Adds layers of what camera rays hit first, unexposed.
    ///
    /// # Errors
    /// [`TooLarge`] if there is not enough memory.
    pub fn with_first_hits(self, layers: FirstHitLayers) -> Result<Self, TooLarge> {
        Ok(Self { first_hits: FirstHits::new(self.area, layers)?, ..self })
    }

    /// The pixels of the picture that it covers.
    pub fn area(&self) -> Area {
        self.area
    }

    /// All pixels, row by row.
    pub fn pixels(&self) -> &[Pixel] {
        &self.pixels
    }

    /// The smallest and largest sample of each pixel, row by row; empty if they are not recorded.
    pub fn spreads(&self) -> &[Spread] {
        &self.spreads
    }

    /// What each pixel shows of surfaces, row by row; empty without layers.
    pub fn features(&self) -> &[Features] {
        &self.features
    }

    /// What the pixel of row-major index `i` shows of surfaces, to be changed; `None` without layers.
    pub fn features_mut(&mut self, i: usize) -> Option<&mut Features> {
        self.features.get_mut(i)
    }

    /// The groups of lights whose light it keeps apart; `None` if it does not.
    pub fn light_groups(&self) -> Option<&LightGroups> {
        self.lights.groups.as_ref()
    }

    /// Exact sums of the light of each named group in the pixel of row-major index `i`, in the order of
    /// the groups; empty without groups. What is missing to the pixel's sum belongs to the group
    /// [`LightGroups::REST`].
    pub fn lights(&self, i: usize) -> &[[Fixed; 3]] {
        self.lights.of(i..i + 1)
    }

    /// The same, to be changed.
    pub fn lights_mut(&mut self, i: usize) -> &mut [[Fixed; 3]] {
        self.lights.of_mut(i..i + 1)
    }

    /// What each pixel shows of what camera rays hit first.
    pub fn first_hits(&self) -> &FirstHits {
        &self.first_hits
    }

    /// The same, to be changed.
    pub fn first_hits_mut(&mut self) -> &mut FirstHits {
        &mut self.first_hits
    }

    /// Pixel and spread of row-major index `i`, to be changed.
    pub fn at_mut(&mut self, i: usize) -> (&mut Pixel, Option<&mut Spread>) {
        (&mut self.pixels[i], self.spreads.get_mut(i))
    }

    /// Copies an area to `film`, which then covers that area.
    pub fn copy_to(&self, area: Area, film: &mut Self) {
        film.area = area;
        film.pixels.clear();
        film.spreads.clear();
        film.features.clear();
        film.lights.clear_for(&self.lights);
        film.first_hits.clear_for(&self.first_hits);
        for row in self.rows(area) {
            film.pixels.extend_from_slice(&self.pixels[row.clone()]);
            if !self.spreads.is_empty() {
                film.spreads.extend_from_slice(&self.spreads[row.clone()]);
            }
            if !self.features.is_empty() {
                film.features.extend_from_slice(&self.features[row.clone()]);
            }
            film.lights.sums.extend_from_slice(self.lights.of(row.clone()));
            film.first_hits.append(&self.first_hits, row);
        }
    }

    /// Copies `film` to its place in this film.
    pub fn put(&mut self, film: &Self) {
        let width = film.area.width() as usize;
        for (i, row) in self.rows(film.area).enumerate() {
            let from = i * width..(i + 1) * width;
            self.pixels[row.clone()].copy_from_slice(&film.pixels[from.clone()]);
            if !self.spreads.is_empty() {
                self.spreads[row.clone()].copy_from_slice(&film.spreads[from.clone()]);
            }
            if !self.features.is_empty() {
                self.features[row.clone()].copy_from_slice(&film.features[from.clone()]);
            }
            self.lights.of_mut(row.clone()).copy_from_slice(film.lights.of(from.clone()));
            self.first_hits.put(row, &film.first_hits, from);
        }
    }

    /// The indices of each row of an area inside this film's.
    pub(super) fn rows(&self, area: Area) -> impl Iterator<Item = std::ops::Range<usize>> + use<> {
        let (own, width) = (self.area, self.area.width() as usize);
        (area.y0..area.y1).map(move |y| {
            let start = (y - own.y0) as usize * width + (area.x0 - own.x0) as usize;
            start..start + area.width() as usize
        })
    }

    /// The mean of each pixel's samples.
    pub fn image(&self) -> Image {
        self.image_of(self.area)
    }

    /// The same of an area inside this film's.
    pub fn image_of(&self, area: Area) -> Image {
        let mut rgb = Vec::with_capacity(area.len());
        rgb.extend(self.pixels_of(area).map(Pixel::mean));
        Image { width: area.width(), height: area.height(), rgb }
    }

    /// The pixels of an area inside this film's, row by row.
    pub fn pixels_of(&self, area: Area) -> impl Iterator<Item = &Pixel> {
        self.rows(area).flat_map(|row| &self.pixels[row])
    }

    /// A copy, if there is memory for it.
    pub fn try_clone(&self) -> Option<Self> {
        Some(Self {
            area: self.area,
            pixels: copied(&self.pixels)?,
            spreads: copied(&self.spreads)?,
            features: copied(&self.features)?,
            lights: GroupSums {
                groups: self.lights.groups.clone(),
                sums: copied(&self.lights.sums)?,
            },
            first_hits: self.first_hits.try_clone()?,
        })
    }

    /// Number of pixels that are brighter than their sums can say.
    pub fn full_pixels(&self) -> usize {
        self.pixels.iter().filter(|pixel| pixel.is_full()).count()
    }

    /// Camera samples of each pixel, row by row: where adaptive sampling went.
    pub fn sample_counts(&self) -> Vec<u32> {
        self.pixels.iter().map(|pixel| pixel.samples).collect()
    }
}

impl Default for Film {
    fn default() -> Self {
        Self {
            area: Area::whole(0, 0),
            pixels: Vec::new(),
            spreads: Vec::new(),
            features: Vec::new(),
            lights: GroupSums::default(),
            first_hits: FirstHits::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{FileLayer, SignedFixed};

    #[test]
    fn areas_land_in_their_places() {
        let mut film = Film::new(Area { x0: 2, y0: 1, x1: 6, y1: 4 }, true).unwrap();
        let area = Area { x0: 3, y0: 2, x1: 5, y1: 4 };
        let mut part = Film::default();
        film.copy_to(area, &mut part);
        (0..4).for_each(|i| part.at_mut(i).0.samples = i as u32 + 1);
        film.put(&part);
        assert_eq!(film.sample_counts(), [0, 0, 0, 0, 0, 1, 2, 0, 0, 3, 4, 0]);
        assert!(film.pixels_of(Area { x0: 4, ..area }).map(|p| p.samples).eq([2, 4]));
        let image = film.image_of(area);
        assert_eq!((image.width, image.height, image.rgb.len()), (2, 2, 4));
    }

    #[test]
    fn features_go_where_pixels_go() {
        let mut film = Film::new(Area::whole(4, 3), false).unwrap().with_features().unwrap();
        let area = Area { x0: 1, y0: 1, x1: 3, y1: 3 };
        let mut part = Film::default();
        film.copy_to(area, &mut part);
        for i in 0..4 {
            part.at_mut(i).0.samples = 1;
            part.features_mut(i).unwrap().albedo = [SignedFixed::clamped(i as f32 / 4.0); 3];
        }
        film.put(&part);
        let layer = film.layer_of(Area { x0: 1, ..film.area() }, &FileLayer::Albedo);
        let expected = [0.0, 0.0, 0.0, 0.0, 0.25, 0.0, 0.5, 0.75, 0.0];
        assert_eq!(layer.rgb, expected.map(|albedo| [albedo; 3]));
        let plain = Film::new(area, false).unwrap();
        assert_eq!(plain.layer_of(area, &FileLayer::Normal).rgb, [[0.0; 3]; 4]);
        film.copy_to(area, &mut part);
        assert_eq!(part.features().len(), 4);
    }

    #[test]
    fn the_light_of_groups_goes_where_pixels_go() {
        let groups = LightGroups::new(["a", "b"]);
        let film = Film::new(Area::whole(4, 3), false).unwrap();
        let mut film = film.with_light_groups(groups.clone()).unwrap();
        let area = Area { x0: 1, y0: 1, x1: 3, y1: 3 };
        let mut part = Film::default();
        film.copy_to(area, &mut part);
        assert_eq!(part.light_groups(), Some(&groups));
        for i in 0..4 {
            part.at_mut(i).0.samples = 1;
            part.lights_mut(i)[1] = [Fixed::new(i as f32 / 4.0).unwrap(); 3];
        }
        film.put(&part);
        assert_eq!(film.try_clone(), Some(film.clone()));
        let layer = |name: &str| film.layer_of(area, &FileLayer::Light(name.into())).rgb;
        assert_eq!(layer("b"), [0.0, 0.25, 0.5, 0.75].map(|light| [light; 3]));
        assert_eq!(layer("a"), [[0.0; 3]; 4]);
        Film::new(area, false).unwrap().copy_to(area, &mut part);
        assert_eq!((part.light_groups(), part.lights(0)), (None, &[][..]));
    }

    #[test]
    fn a_film_that_memory_can_not_hold_is_refused() {
        // 65536 x 65536 pixels fit no address space limit of a test, so ask for more.
        assert!(Film::new(Area::whole(u32::MAX, u32::MAX), false).is_err());
    }
}
