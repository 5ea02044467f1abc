//! The triangles in the order of leaves, block by block in rows.

use std::sync::atomic::{AtomicU32, Ordering};

use rayon::prelude::*;

use crate::math::Bounds;
use crate::primitives::Triangle;
use crate::structure::bvh::layout::{
    Corners, FIRST_CHANGE, ID_ROW, Node, Place, nodes_per_node, rows_of,
};

/// Nodes whose blocks one task fills.
const TASK: usize = 256;

/// The triangles that leaves hold.
pub(in crate::structure::bvh) struct Shapes<'a> {
    pub(in crate::structure::bvh) starts: &'a [Triangle],
    /// Where they move to, if they do.
    pub(in crate::structure::bvh) ends: Option<&'a [Triangle]>,
}

impl Shapes<'_> {
    /// The boxes about a triangle at the start and at the end.
    pub(super) fn boxes(&self, id: u32) -> [Bounds; 2] {
        let ends = self.ends.unwrap_or(self.starts);
        [self.starts, ends].map(|triangles| Bounds::of_points(triangles[id as usize]))
    }

    pub(super) fn moves(&self) -> bool {
        self.ends.is_some()
    }

    fn rows(&self) -> usize {
        rows_of(self.moves())
    }

    /// Writes a block of triangles in rows.
    pub(super) fn write(&self, rows: &mut [f32], block: &[u32]) {
        let n = block.len();
        for (lane, &id) in block.iter().enumerate() {
            let start = &self.starts[id as usize];
            rows[ID_ROW * n + lane] = f32::from_bits(id);
            for (corner, p) in start.iter().enumerate() {
                for axis in 0..3 {
                    rows[(3 * corner + axis) * n + lane] = p[axis];
                }
            }
            let Some(ends) = self.ends else { continue };
            for (corner, p) in ends[id as usize].iter().enumerate() {
                let change = p - start[corner];
                for axis in 0..3 {
                    rows[(FIRST_CHANGE + 3 * corner + axis) * n + lane] = change[axis];
                }
            }
        }
    }
}

/// Writes the triangles of all blocks that nodes name, and notes where each triangle is first.
/// `ids` are those of the triangles by slot: first the `slots` of blocks, which follow each other in
/// the order of nodes, then triangles that are in no leaf.
pub(super) fn fill(
    shapes: &Shapes,
    nodes: &[Node],
    (ids, slots): (&[u32], usize),
    has_pieces: bool,
) -> (Corners, Vec<Place>) {
    let rows = shapes.rows();
    let places: Vec<AtomicU32> =
        (0..shapes.starts.len()).into_par_iter().map(|_| AtomicU32::new(u32::MAX)).collect();
    // Of a triangle that was cut the lowest place counts, in any order of tasks.
    let put = |id: u32, place: Place| {
        let known = &places[id as usize];
        if has_pieces {
            known.fetch_min(place.0, Ordering::Relaxed);
        } else {
            known.store(place.0, Ordering::Relaxed);
        }
    };
    let mut corners = Corners::new(ids.len(), shapes.moves());
    let (mut of_leaves, of_others) = corners.rows_mut().split_at_mut(slots * rows);
    let mut begin = 0;
    let tasks: Vec<_> = nodes
        .chunks(nodes_per_node(shapes.moves()) * TASK)
        .map(|nodes| {
            let blocks = nodes.iter().flat_map(|node| node.children).filter(|of| of.is_block());
            let count: usize = blocks.map(|block| block.block_len()).sum();
            let (of_task, later) = std::mem::take(&mut of_leaves).split_at_mut(count * rows);
            of_leaves = later;
            begin += count;
            (nodes, begin - count, of_task)
        })
        .collect();
    tasks.into_par_iter().for_each(|(nodes, begin, of_task)| {
        for child in nodes.iter().flat_map(|node| node.children).filter(|of| of.is_block()) {
            let (slot, count) = (child.index(), child.block_len());
            let block = &ids[slot..slot + count];
            shapes.write(&mut of_task[(slot - begin) * rows..], block);
            for (lane, &id) in (0..).zip(block) {
                put(id, Place::new(slot as u32, count as u32, lane));
            }
        }
    });
    for ((slot, &id), rows) in (slots..).zip(&ids[slots..]).zip(of_others.chunks_mut(rows)) {
        shapes.write(rows, &[id]);
        put(id, Place::new(slot as u32, 1, 0));
    }
    let places = places.into_iter().map(|place| Place(place.into_inner())).collect();
    (corners, places)
}
