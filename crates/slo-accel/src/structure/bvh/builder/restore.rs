//! What is kept of a hierarchy, and the hierarchy made of it again: its nodes, and the ids of the
//! triangles in the order of leaves. Corners come from the primitives.
//!
//! The nodes may come from anybody. They are used only if each of them is the child of one that
//! stands before it, if blocks of triangles follow each other without gaps, and if all triangles
//! are in some block. Every ray then comes to an end, and whatever it visits exists.

use std::borrow::Cow;

use rayon::prelude::*;

use super::assemble;
use super::collapse::Wide;
use super::rows::{Shapes, fill};
use crate::math::Bounds;
use crate::primitives::Primitives;
use crate::structure::bvh::hierarchy::Bvh;
use crate::structure::bvh::layout::{Child, MAX_SLOTS, Node, WIDTH};
use crate::structure::interface::{BuildOptions, Sections};
use crate::structure::shared::pages::{Array, bytes_of, bytes_of_mut};

/// Sections of what is kept.
const NODES: usize = 0;
const IDS: usize = 1;

/// Blocks whose box one task finds.
const TASK: usize = 256;

/// Most levels of a hierarchy that is restored. Each takes working memory of every thread.
const MOST_LEVELS: u16 = 1024;

/// Returns the nodes, and the ids of the triangles in the order of leaves, followed by those that are
/// in no leaf.
pub(in crate::structure::bvh) fn kept(bvh: &Bvh) -> Vec<Cow<'_, [u8]>> {
    let (ids, _) = ids_by_slot(bvh);
    vec![Cow::Borrowed(bytes_of(&bvh.nodes)), Cow::Owned(bytes_of(&ids).to_vec())]
}

/// Returns the ids of all triangles by slot, and how many slots are in leaves; the others follow.
pub(super) fn ids_by_slot(bvh: &Bvh) -> (Vec<u32>, usize) {
    let children = bvh.nodes.iter().flat_map(|node| node.children);
    let blocks = children.filter(|child| child.is_block());
    let mut ids: Vec<u32> = Vec::with_capacity(bvh.corners.slots());
    for block in blocks {
        let (slot, count) = (block.index(), block.block_len());
        ids.extend((0..count).map(|lane| bvh.corners.id(slot, count, lane)));
    }
    let in_leaves = ids.len();
    ids.extend((in_leaves..bvh.corners.slots()).map(|slot| bvh.corners.id(slot, 1, 0)));
    (ids, in_leaves)
}

/// See [`restore`](crate::structure::interface::SpatialIndex::restore).
pub(in crate::structure::bvh) fn restore(
    primitives: Primitives,
    options: BuildOptions,
    sections: &dyn Sections,
) -> Result<Bvh, Primitives> {
    match wide(&primitives, sections) {
        Some((wide, bounds)) => Ok(assemble(wide, primitives.curved, bounds, options.isa)),
        None => Err(primitives),
    }
}

/// Reads the parts of a hierarchy over `primitives`, and the box about all of them.
fn wide(primitives: &Primitives, sections: &dyn Sections) -> Option<(Wide, Bounds)> {
    let nodes = exactly::<Node>(sections.length(NODES)?)?;
    let slots = exactly::<u32>(sections.length(IDS)?)?;
    if slots > MAX_SLOTS {
        return None;
    }
    let mut nodes = Array::filled(Node::EMPTY, nodes);
    let mut ids = vec![0u32; slots];
    let are_read = sections.read(NODES, bytes_of_mut(&mut nodes))
        && sections.read(IDS, bytes_of_mut(&mut ids));
    let count = primitives.triangles.len();
    if !are_read || ids.par_iter().any(|id| *id as usize >= count) {
        return None;
    }
    let order = Order::of(&nodes, slots, primitives.curved.len())?;
    let shapes = Shapes { starts: &primitives.triangles, ends: None };
    // A triangle that was cut is in several places.
    let (corners, places) = fill(&shapes, &nodes, (&ids, order.in_leaves), true);
    if places.par_iter().any(|place| place.0 == u32::MAX) {
        return None;
    }
    let (_, hollow) = ids.split_at(order.in_leaves);
    let bounds = order.bounds(primitives, &ids[..order.in_leaves]);
    let bounds = hollow.iter().fold(bounds, |all, &id| all.union(primitives.bounds(id)));
    Some((Wide { nodes, corners, places, depth: order.depth }, bounds))
}

/// How many values of a type fill so many bytes.
fn exactly<T>(bytes: usize) -> Option<usize> {
    bytes.is_multiple_of(size_of::<T>()).then_some(bytes / size_of::<T>())
}

/// How the triangles of leaves follow each other.
struct Order {
    /// Slots of leaves; those of triangles in no leaf follow.
    in_leaves: usize,
    depth: usize,
}

impl Order {
    /// Reads the order off nodes. `None` if they make no hierarchy.
    fn of(nodes: &[Node], slots: usize, curved: usize) -> Option<Self> {
        // Level of each node, from 1; 0 before anything leads to it.
        let mut levels = vec![0u16; nodes.len()];
        if let Some(root) = levels.first_mut() {
            *root = 1;
        }
        let (mut slot, mut depth) = (0, 0);
        for (number, node) in nodes.iter().enumerate() {
            let level = levels[number];
            if !(1..=MOST_LEVELS).contains(&level) {
                return None;
            }
            depth = depth.max(level);
            for (place, child) in node.children.into_iter().enumerate() {
                let is_sound = if child == Child::DONE {
                    node.is_closed(place)
                } else if child.is_block() {
                    let begin = slot;
                    slot += child.block_len();
                    child.index() == begin
                } else if child.is_leaf() {
                    child.index() < curved
                } else {
                    let below = child.0 as usize;
                    let is_new = below > number && levels.get(below) == Some(&0);
                    if is_new {
                        levels[below] = level + 1;
                    }
                    is_new
                };
                if !is_sound {
                    return None;
                }
            }
        }
        (slot <= slots).then_some(Self { in_leaves: slot, depth: depth.into() })
    }

    /// The box about the triangles of leaves and all curved surfaces.
    fn bounds(&self, primitives: &Primitives, ids: &[u32]) -> Bounds {
        let chunks: Vec<Bounds> = ids
            .par_chunks(TASK * WIDTH)
            .map(|ids| ids.iter().fold(Bounds::EMPTY, |all, &id| all.union(primitives.bounds(id))))
            .collect();
        let curved = primitives.curved.iter().map(|curved| curved.bounds());
        chunks.into_iter().chain(curved).fold(Bounds::EMPTY, Bounds::union)
    }
}
