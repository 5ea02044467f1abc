//! The two-level tree's one level: a kd-tree built by the surface area heuristic.

use super::{Coherence, Hits, Isa, Primitives, Rays, Scratch};

/// A kd-tree over primitives.
#[derive(Debug)]
pub struct KdTree {
    primitives: Primitives,
}

impl KdTree {
    /// Builds the tree.
    pub fn build(primitives: Primitives, _isa: Isa) -> Self {
        Self { primitives }
    }

    pub(super) fn primitives(&self) -> &Primitives {
        &self.primitives
    }

    pub(super) fn intersect(&self, _: &Rays, _: Coherence, _: &mut Hits, _: &mut Scratch) {
        todo!()
    }

    pub(super) fn occluded(&self, _: &Rays, _: Coherence, _: &mut [bool], _: &mut Scratch) {
        todo!()
    }
}
