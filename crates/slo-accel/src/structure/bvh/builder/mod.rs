//! Builds the hierarchy, on all threads of the current rayon pool; it is the same for any number of
//! them.
//!
//! First comes a binary hierarchy, built by binned SAH ([`binary`]); on request, triangles are cut
//! ([`spatial`]). Dynamic programming decides the fate of its nodes ([`plan`]), which are then
//! [collapsed](collapse). Triangles that have moved a little since may [keep](mod@refit) their hierarchy.

mod binary;
mod bins;
mod boxes;
mod collapse;
mod family;
mod few;
mod fit;
mod heuristic;
mod plan;
mod refit;
mod restore;
mod rows;
mod spatial;
mod tree;

use rayon::prelude::*;

use self::boxes::{Box8, Reference, extent};
use self::collapse::Wide;
pub(super) use self::refit::refit;
pub(super) use self::restore::{kept, restore};
pub(super) use self::rows::Shapes;
use super::hierarchy::{Bvh, FAR};
use super::layout::{Node, stack_size};
use super::ray::TAME_COORDINATE;
use crate::isa::Isa;
use crate::math::Bounds;
use crate::primitives::{Curved, Primitives, Triangle, triangle};
use crate::structure::interface::BuildOptions;
use crate::structure::shared::pages::Array;

/// So many primitives need memory that their references should leave for what is built of them.
const VERY_MANY: usize = 1 << 20;

/// Builds the hierarchy over primitives.
pub(super) fn build(primitives: Primitives, options: BuildOptions) -> Bvh {
    let BuildOptions { isa, spatial_splits, .. } = options;
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
    let mut tree = match spatial_splits {
        true => spatial::build(references, extent, &primitives.triangles, isa),
        false => binary::build(references, extent, triangle_count as u32, isa),
    };
    let of_whole = |id: u32| primitives.bounds(id);
    if primitives.len() >= VERY_MANY {
        tree.forget_boxes(&of_whole);
    }
    let shapes = Shapes { starts: &primitives.triangles, ends: None };
    let wide = collapse::collapse(tree, &shapes, left_out);
    assemble(wide, primitives.curved, bounds, options.isa)
}

/// Builds the hierarchy over triangles that move, each from where it is in the first shape to where
/// it is in the second.
pub(super) fn build_moving(starts: &[Triangle], ends: &[Triangle], isa: Isa) -> Bvh {
    let shapes = Shapes { starts, ends: Some(ends) };
    // Splits are chosen by boxes in the middle of the time.
    let (references, left_out, extent) = references(starts.len(), |id| {
        let [a, b] = shapes.boxes(id);
        (!is_hollow(&shapes, id))
            .then_some(Bounds { min: 0.5 * a.min + 0.5 * b.min, max: 0.5 * a.max + 0.5 * b.max })
    });
    let bounds = references
        .par_iter()
        .map(|r| shapes.boxes(r.id()))
        .map(|[a, b]| a.union(b))
        .reduce(|| Bounds::EMPTY, Bounds::union);
    let tree = binary::build(references, extent, starts.len() as u32, isa);
    let wide = collapse::collapse(tree, &shapes, &left_out);
    Bvh { moves: true, ..assemble(wide, vec![], bounds, isa) }
}

fn assemble(wide: Wide, curved: Vec<Curved>, bounds: Bounds, isa: Isa) -> Bvh {
    let Wide { nodes, corners, places, depth } = wide;
    let largest = bounds.min.abs().max(bounds.max.abs()).max_element();
    let mut bvh = Bvh {
        nodes,
        corners,
        places,
        curved,
        bounds,
        stack: stack_size(depth),
        isa,
        is_tame: largest <= TAME_COORDINATE,
        is_far: false,
        moves: false,
        built_cost: None,
    };
    bvh.is_far = bvh.bytes() > FAR;
    bvh
}

/// Whether a triangle is left out: it has a coordinate that is not finite, or no area.
fn is_hollow(shapes: &Shapes, id: u32) -> bool {
    let start = &shapes.starts[id as usize];
    match shapes.ends {
        Some(ends) => is_never_hit(start, &ends[id as usize]),
        None => triangle::is_degenerate(start) || shapes.boxes(id)[0].is_empty(),
    }
}

/// Whether a triangle that moves is left out: it has a coordinate that is not finite, or no area
/// at the start, in the middle, and at the end; then it has none at any time.
pub(in crate::structure) fn is_never_hit(start: &Triangle, end: &Triangle) -> bool {
    let is_finite = |t: &Triangle| t.iter().all(|p| p.is_finite());
    let change: Triangle = std::array::from_fn(|corner| end[corner] - start[corner]);
    let at = |time: f32| std::array::from_fn(|corner| start[corner] + change[corner] * time);
    !(is_finite(start) && is_finite(end) && is_finite(&change))
        || [start, &at(0.5), end].into_iter().all(triangle::is_degenerate)
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
    let nothing = Shapes { starts: &[], ends: None };
    let tree = binary::build(references, extent, 0, isa);
    let Wide { nodes, depth, .. } = collapse::collapse(tree, &nothing, &[]);
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
