//! Builds the hierarchy, on all threads of the current rayon pool; it is the same for any number of
//! them.
//!
//! First comes a binary hierarchy, built by binned SAH ([`binary`]); on request, triangles are cut
//! ([`spatial`]). Dynamic programming decides the fate of its nodes ([`plan`]), which are then
//! [collapsed](collapse).

mod binary;
mod bins;
mod boxes;
mod collapse;
mod family;
mod few;
mod heuristic;
mod plan;
mod spatial;
mod tree;

use rayon::prelude::*;

use self::boxes::{Box8, Reference, extent};
use self::collapse::Wide;
use super::hierarchy::{Bvh, FAR};
use super::layout::{Node, stack_size};
use super::ray::TAME_COORDINATE;
use crate::isa::Isa;
use crate::math::Bounds;
use crate::primitives::{Primitives, triangle};
use crate::structure::interface::BuildOptions;
use crate::structure::shared::pages::Array;

/// Builds the hierarchy over primitives.
pub(super) fn build(primitives: Primitives, options: BuildOptions) -> Bvh {
    let BuildOptions { isa, spatial_splits } = options;
    let triangle_count = primitives.triangles.len();
    let bounds = |id: u32| {
        let bounds = primitives.bounds(id);
        let triangle = primitives.triangles.get(id as usize);
        let is_hollow = triangle.is_some_and(triangle::is_degenerate) || bounds.is_empty();
        (!is_hollow).then_some(bounds)
    };
    let (references, left_out, extent) = references(primitives.len(), bounds);
    let bounds =
        left_out.iter().fold(extent[0].bounds(), |all, &id| all.union(primitives.bounds(id)));
    let left_out = &left_out[..left_out.partition_point(|&id| (id as usize) < triangle_count)];
    let tree = match spatial_splits {
        true => spatial::build(references, extent, &primitives.triangles, isa),
        false => binary::build(references, extent, triangle_count as u32, isa),
    };
    let Wide { nodes, corners, places, depth } =
        collapse::collapse(tree, &primitives.triangles, left_out);
    let largest = bounds.min.abs().max(bounds.max.abs()).max_element();
    let mut bvh = Bvh {
        nodes,
        corners,
        places,
        curved: primitives.curved,
        bounds,
        stack: stack_size(depth),
        isa,
        is_tame: largest <= TAME_COORDINATE,
        is_far: false,
    };
    bvh.is_far = bvh.bytes() > FAR;
    bvh
}

/// Builds a hierarchy over `count` boxes; those that are `None` are left out. Each leaf is a box,
/// by its number, which stands where a curved surface would. Returns the nodes, and how many there
/// are from the root to the deepest, both counted.
pub(super) fn build_over(
    count: usize,
    bounds: impl Fn(u32) -> Option<Bounds> + Sync,
    isa: Isa,
) -> (Array<Node>, usize) {
    let (references, _, extent) = references(count, bounds);
    let Wide { nodes, depth, .. } =
        collapse::collapse(binary::build(references, extent, 0, isa), &[], &[]);
    (nodes, depth)
}

/// Primitives for which one task makes references.
const TASK: usize = 1 << 13;

/// References to the primitives that have a box, the ids of the others, and the [`extent`].
fn references(
    count: usize,
    bounds: impl Fn(u32) -> Option<Bounds> + Sync,
) -> (Vec<Reference>, Vec<u32>, [Box8; 2]) {
    let mut references: Vec<Reference> = (0..count as u32)
        .into_par_iter()
        .map(|id| bounds(id).map_or(Reference::NONE, |bounds| Reference::new(bounds, id)))
        .collect();
    let hollow = |(id, r): (usize, &Reference)| r.is_none().then_some(id as u32);
    let left_out: Vec<u32> = references.par_iter().enumerate().filter_map(hollow).collect();
    if !left_out.is_empty() {
        references.retain(|r| !r.is_none());
    }
    let extents: Vec<_> = references.par_chunks(TASK).map(extent).collect();
    let extent = extents.iter().fold([Box8::EMPTY; 2], |[all, centers], part| {
        [all.union(&part[0]), centers.union(&part[1])]
    });
    (references, left_out, extent)
}
