//! Tests every primitive: the oracle that the structures are held against.

use super::{Hits, Primitives, Rays};

/// Primitives without a structure.
#[derive(Debug)]
pub struct Brute {
    primitives: Primitives,
}

impl Brute {
    pub(super) fn new(primitives: Primitives) -> Self {
        Self { primitives }
    }

    pub(super) fn primitives(&self) -> &Primitives {
        &self.primitives
    }

    pub(super) fn intersect(&self, _rays: &Rays, _hits: &mut Hits) {
        todo!()
    }

    pub(super) fn occluded(&self, _rays: &Rays, _blocked: &mut [bool]) {
        todo!()
    }
}
