//! Boxes of a hierarchy whose nodes and blocks are known.

use rayon::prelude::*;

use super::rows::Shapes;
use crate::math::Bounds;
use crate::structure::bvh::layout::{Child, Node, nodes_per_node};

/// Nodes whose boxes one task finds.
const TASK: usize = 256;

/// Sets the boxes of all nodes, from the triangles of `ids`, by slot. What moves straight from start
/// to end stays between planes that do, so boxes at both times are as tight as they can be. Returns
/// the boxes about all of them at the start and at the end.
pub(super) fn fit(nodes: &mut [Node], shapes: &Shapes, ids: &[u32]) -> [Bounds; 2] {
    let per_node = nodes_per_node(shapes.moves());
    let mut about = vec![[Bounds::EMPTY; 2]; nodes.len() / per_node];
    // Blocks first, in any order.
    let tasks = nodes.par_chunks_mut(per_node * TASK).zip(about.par_chunks_mut(TASK));
    tasks.for_each(|(nodes, about)| {
        for (nodes, about) in nodes.chunks_exact_mut(per_node).zip(about) {
            if let Some(change) = nodes.get_mut(1) {
                *change = Node::AT_REST;
            }
            for (place, child) in nodes[0].children.into_iter().enumerate() {
                if child.is_block() {
                    let block = &ids[child.index()..][..child.block_len()];
                    let boxes = block.iter().map(|&id| shapes.boxes(id));
                    let boxes = boxes.fold([Bounds::EMPTY; 2], both);
                    set(nodes, place, child, boxes);
                    *about = both(*about, boxes);
                }
            }
        }
    });
    // Then nodes: children stand behind their parents.
    for number in (0..about.len()).rev() {
        let nodes = &mut nodes[number * per_node..][..per_node];
        for (place, child) in nodes[0].children.into_iter().enumerate() {
            if !child.is_leaf() {
                let boxes = about[child.index() / per_node];
                set(nodes, place, child, boxes);
                about[number] = both(about[number], boxes);
            }
        }
    }
    about.first().copied().unwrap_or([Bounds::EMPTY; 2])
}

fn both([start, end]: [Bounds; 2], [a, b]: [Bounds; 2]) -> [Bounds; 2] {
    [start.union(a), end.union(b)]
}

fn set(nodes: &mut [Node], place: usize, child: Child, boxes: [Bounds; 2]) {
    match nodes.len() {
        1 => nodes[0].set(place, child, boxes[0]),
        _ => Node::set_moving(nodes, place, child, boxes),
    }
}
