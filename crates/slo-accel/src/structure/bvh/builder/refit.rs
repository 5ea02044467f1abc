//! The hierarchy over triangles that have moved a little, made of the one over where they were
//! before: nodes and blocks stay, and boxes follow the triangles.
//!
//! Boxes of triangles that drift apart overlap more and more. The expected cost of a ray, by the
//! surface area heuristic, tells how much slower rays are: each step through a node and each block
//! costs 1.

use rayon::prelude::*;

use super::collapse::Wide;
use super::fit::fit;
use super::restore::ids_by_slot;
use super::rows::{Shapes, fill};
use super::{assemble, is_hollow};
use crate::isa::Isa;
use crate::math::Bounds;
use crate::structure::bvh::hierarchy::Bvh;
use crate::structure::bvh::layout::{Child, Node, WIDTH, nodes_per_node};
use crate::structure::shared::pages::Array;

/// Nodes whose cost one task finds.
const TASK: usize = 256;

/// Fits a hierarchy over triangles to where they are now. `None`: rays would cost more than
/// `most_growth` times what they cost in the hierarchy that was built, or these are other triangles.
pub(in crate::structure::bvh) fn refit(
    old: &Bvh,
    shapes: &Shapes,
    most_growth: f64,
    isa: Isa,
) -> Option<Bvh> {
    let count = shapes.starts.len();
    let (ids, in_leaves) = ids_by_slot(old);
    let are_same = old.moves == shapes.moves()
        && old.places.len() == count
        && old.curved.is_empty()
        && ids.len() == count;
    if !are_same || in_leaves == 0 {
        return None;
    }
    let (seen, left_out) = ids.split_at(in_leaves);
    let fits = |id: &u32, leaf: bool| is_hollow(shapes, *id) != leaf;
    if !seen.par_iter().all(|id| fits(id, true)) || !left_out.iter().all(|id| fits(id, false)) {
        return None;
    }
    let mut nodes = Array::filled(Node::EMPTY, old.nodes.len());
    nodes.copy_from_slice(&old.nodes);
    let [start, end] = fit(&mut nodes, shapes, &ids);
    let built = old.built_cost.unwrap_or_else(|| cost(&old.nodes, old.moves));
    if cost(&nodes, old.moves) > most_growth * built {
        return None;
    }
    let (corners, places) = fill(shapes, &nodes, (&ids, in_leaves), false);
    let mut bounds = start.union(end);
    if !shapes.moves() {
        let of_left_out = left_out.iter().map(|&id| shapes.boxes(id)[0]);
        bounds = of_left_out.fold(bounds, Bounds::union);
    }
    let wide = Wide { nodes, corners, places, depth: 0 };
    let (moves, stack) = (old.moves, old.stack);
    let built_cost = Some(built);
    Some(Bvh { moves, stack, built_cost, ..assemble(wide, vec![], bounds, isa) })
}

/// The expected cost of a ray that hits the box of all: how many boxes it hits, in the middle of the
/// time.
fn cost(nodes: &[Node], moves: bool) -> f64 {
    let per_node = nodes_per_node(moves);
    let area = |nodes: &[Node]| boxes(nodes).map(|of| f64::from(of.area())).sum::<f64>();
    // Sums in the order of nodes, whichever thread makes them.
    let tasks: Vec<f64> = nodes
        .par_chunks(per_node * TASK)
        .map(|nodes| nodes.chunks_exact(per_node).map(area).sum())
        .collect();
    let all = boxes(&nodes[..per_node]).fold(Bounds::EMPTY, Bounds::union);
    tasks.iter().sum::<f64>() / f64::from(all.area()).max(f64::MIN_POSITIVE)
}

/// The boxes of a node's children, in the middle of the time.
fn boxes(nodes: &[Node]) -> impl Iterator<Item = Bounds> {
    let children = (0..WIDTH).filter(|&place| nodes[0].children[place] != Child::DONE);
    children.map(|place| {
        let plane = |row: usize| {
            let change = nodes.get(1).map_or(0.0, |change| change.planes[row][place]);
            nodes[0].planes[row][place] + 0.5 * change
        };
        let side = |side: usize| [0, 1, 2].map(|axis| plane(2 * axis + side)).into();
        Bounds { min: side(0), max: side(1) }
    })
}
