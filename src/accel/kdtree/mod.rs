//! A kd-tree built by the surface area heuristic.

mod build;
mod leaf;
mod node;
mod ray;
mod single;
#[cfg(test)]
mod tests;

use build::MAX_DEPTH;
use leaf::{Arena, Best};
use node::Node;

use super::{Coherence, Hits, Isa, NO_HIT, Primitives, Rays, Scratch};
use crate::math::Bounds;

/// A kd-tree over primitives.
#[derive(Debug)]
pub struct KdTree {
    primitives: Primitives,
    bounds: Bounds,
    /// Root first; siblings are neighbours.
    nodes: Vec<Node>,
    arena: Arena,
}

impl KdTree {
    /// Builds the tree.
    pub fn build(primitives: Primitives, _isa: Isa) -> Self {
        let built = build::build(&primitives);
        Self { primitives, bounds: built.bounds, nodes: built.nodes, arena: built.arena }
    }

    pub(super) fn primitives(&self) -> &Primitives {
        &self.primitives
    }

    /// Bytes that it holds beyond the primitives.
    pub(super) fn memory(&self) -> usize {
        std::mem::size_of_val(self.nodes.as_slice())
            + std::mem::size_of_val(self.arena.words.as_slice())
    }

    pub(super) fn intersect(&self, rays: &Rays, _: Coherence, hits: &mut Hits, _: &mut Scratch) {
        for i in 0..rays.len() {
            let best = self.trace::<false>(rays, i);
            if best.is_hit() {
                (hits.t[i], hits.u[i], hits.v[i]) = (best.t, best.u, best.v);
                hits.primitive[i] = best.primitive;
            }
        }
    }

    pub(super) fn occluded(
        &self,
        rays: &Rays,
        _: Coherence,
        blocked: &mut [bool],
        _: &mut Scratch,
    ) {
        for (i, blocked) in blocked.iter_mut().enumerate().take(rays.len()) {
            *blocked = self.trace::<true>(rays, i).is_hit();
        }
    }

    fn trace<const ANY: bool>(&self, rays: &Rays, i: usize) -> Best {
        let (origin, direction, t_max) = (rays.origin(i), rays.direction(i), rays.t_max[i]);
        single::trace::<ANY>(self, origin, direction, t_max, &single::Portable)
    }
}
