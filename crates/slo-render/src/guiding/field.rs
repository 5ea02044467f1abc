//! The field that was learned, for use.

use glam::Vec3;

use super::places::{Grid, Node, leaf_of};
use super::quads::{Quad, density, sample};

/// What a field knows of a place: the number of its guide.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Guide {
    /// Number of its first node among all; [`NOWHERE`] if rays are not guided.
    pub(super) root: u32,
    /// Chance, of 256, that the direction of a ray is taken from the field: for lobes that are not
    /// diffuse, and for those that are.
    pub(super) share: [u8; 2],
}

/// The guide of places where rays are not guided.
pub const NOWHERE: u32 = u32::MAX;

/// A field that says where light comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    pub(super) grid: Grid,
    pub(super) nodes: Vec<Node>,
    /// For each leaf.
    pub(super) guides: Vec<Guide>,
    pub(super) quads: Vec<Quad>,
}

impl Guide {
    /// The guide as a word, for columns.
    #[inline(always)]
    pub fn word(self) -> u32 {
        self.root
    }

    /// Chance that the direction of a ray is taken from the field.
    #[inline(always)]
    pub fn share(self, is_diffuse: bool) -> f32 {
        f32::from(self.share[usize::from(is_diffuse)]) * (1.0 / 256.0)
    }
}

impl Field {
    /// Returns the guide of a place.
    #[inline(always)]
    pub fn guide(&self, place: Vec3) -> Guide {
        let leaf = leaf_of(&self.nodes, self.grid.steps(place));
        self.guides.get(leaf as usize).copied().unwrap_or(Guide { root: NOWHERE, share: [0; 2] })
    }

    /// Returns the density, per solid angle, of a [packed](super::pack) direction. `guide` is the
    /// [word](Guide::word) of a guide of this field.
    #[inline(always)]
    pub fn density(&self, guide: u32, packed: u32) -> f32 {
        let tree = self.quads.get(guide as usize..).unwrap_or(&[]);
        if tree.is_empty() { 0.0 } else { density(tree, packed) }
    }

    /// Returns a point of the square of directions by a point of the unit square.
    #[inline(always)]
    pub fn sample(&self, guide: u32, u: [f32; 2]) -> [f32; 2] {
        sample(self.quads.get(guide as usize..).unwrap_or(&[]), u)
    }

    /// Number of leaves, and of nodes of all quadtrees.
    pub fn sizes(&self) -> [usize; 2] {
        [self.guides.len(), self.quads.len()]
    }

    /// Returns the share of leaves where rays are guided, of each class of lobes.
    pub fn guided(&self) -> [f64; 2] {
        [0, 1].map(|class| {
            let sum: f64 = self.guides.iter().map(|guide| f64::from(guide.share[class])).sum();
            sum / 256.0 / self.guides.len().max(1) as f64
        })
    }
}
