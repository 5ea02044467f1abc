//! The light of groups of lights: exact sums, beside the sums of all light.

use slo_scene::LightGroups;

use super::fixed::Fixed;

/// Sums of the light of each named group; what is missing to the sum of all light belongs to the group
/// [`LightGroups::REST`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct GroupSums {
    /// `None`: nobody asks for them.
    pub(super) groups: Option<LightGroups>,
    /// Red, green, blue of each group of each pixel: the groups of a pixel are neighbours.
    pub(super) sums: Vec<[Fixed; 3]>,
}

impl GroupSums {
    /// Number of sums of a pixel.
    pub(super) fn per_pixel(&self) -> usize {
        self.groups.as_ref().map_or(0, LightGroups::len)
    }

    /// The sums of pixels with these indices.
    pub(super) fn of(&self, pixels: std::ops::Range<usize>) -> &[[Fixed; 3]] {
        let each = self.per_pixel();
        self.sums.get(pixels.start * each..pixels.end * each).unwrap_or_default()
    }

    /// The same, to be changed.
    pub(super) fn of_mut(&mut self, pixels: std::ops::Range<usize>) -> &mut [[Fixed; 3]] {
        let each = self.per_pixel();
        self.sums.get_mut(pixels.start * each..pixels.end * each).unwrap_or_default()
    }

    /// Removes the sums of all pixels, and takes over the groups of another film.
    pub(super) fn clear_for(&mut self, other: &Self) {
        self.groups.clone_from(&other.groups);
        self.sums.clear();
    }
}
