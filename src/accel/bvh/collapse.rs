//! From the planned binary hierarchy to nodes, blocks of triangles, and their ids.

use glam::Vec3;
use rayon::prelude::*;

use super::binary::BinaryTree;
use super::layout::{Child, Corners, Node, Place, WIDTH};
use super::plan::Family;
use crate::accel::Triangle;

/// Wide nodes that one task writes.
const TASK: usize = 256;

/// The parts of a finished hierarchy.
pub(super) struct Wide {
    pub(super) nodes: Vec<Node>,
    pub(super) corners: Corners,
    /// Ids of the triangles, by slot.
    pub(super) ids: Vec<u32>,
    /// Where each triangle is, by id.
    pub(super) places: Vec<Place>,
    /// How many nodes there are from the root to the deepest, both counted.
    pub(super) depth: usize,
}

/// A wide node to be written.
#[derive(Clone, Copy)]
struct Draft {
    /// The binary node that it stands for.
    root: u32,
    first_slot: u32,
}

/// Writes the wide hierarchy; `left_out` are triangles without area, which get a place but no leaf.
pub(super) fn collapse(mut tree: BinaryTree, triangles: &[Triangle], left_out: &[u32]) -> Wide {
    let (drafts, slots, depth) = draft(&mut tree, triangles.len() as u32);
    let mut rows = vec![0.0; triangles.len() * Corners::PER_TRIANGLE];
    let mut ids = vec![0; triangles.len()];
    let (leaf_rows, other_rows) = rows.split_at_mut(slots * Corners::PER_TRIANGLE);
    let (leaf_ids, other_ids) = ids.split_at_mut(slots);
    let writer = Writer { tree: &tree, triangles };
    let nodes = writer.write_all(&drafts, leaf_rows, leaf_ids);
    for (i, &id) in left_out.iter().enumerate() {
        other_ids[i] = id;
        write_block(&mut other_rows[i * Corners::PER_TRIANGLE..], &[id], triangles);
    }
    let places = places(&nodes, &ids, slots);
    Wide { nodes, corners: Corners::new(rows), ids, places, depth }
}

/// Numbers the wide nodes, parents before children and subtrees together; each binary node that
/// becomes one holds its number in `first` afterwards. Also the slots used and the depth.
fn draft(tree: &mut BinaryTree, first_curved: u32) -> (Vec<Draft>, usize, usize) {
    let mut drafts = Vec::new();
    let (mut slots, mut depth) = (0, 0);
    let mut family = Family::default();
    let mut stack = if tree.nodes.is_empty() { vec![] } else { vec![(0, 1)] };
    while let Some((root, level)) = stack.pop() {
        depth = depth.max(level);
        family.gather(tree, root);
        tree.nodes[root as usize].first = drafts.len() as u32;
        drafts.push(Draft { root, first_slot: slots });
        for &child in family.children.iter().rev() {
            if !is_leaf(tree, child) {
                stack.push((child, level + 1));
            } else if tree.references[tree.node(child).first as usize].id() < first_curved {
                slots += tree.node(child).count;
            }
        }
    }
    (drafts, slots as usize, depth)
}

fn is_leaf(tree: &BinaryTree, node: u32) -> bool {
    let node = tree.node(node);
    node.count == 1 || node.plan.is_leaf()
}

struct Writer<'a> {
    tree: &'a BinaryTree,
    triangles: &'a [Triangle],
}

impl Writer<'_> {
    fn write_all(&self, drafts: &[Draft], mut rows: &mut [f32], mut ids: &mut [u32]) -> Vec<Node> {
        let mut nodes = vec![Node::EMPTY; drafts.len()];
        let slots = ids.len() as u32;
        let tasks: Vec<_> = nodes
            .chunks_mut(TASK)
            .zip(drafts.chunks(TASK))
            .enumerate()
            .map(|(i, (nodes, task))| {
                let end = drafts.get((i + 1) * TASK).map_or(slots, |next| next.first_slot);
                let count = (end - task[0].first_slot) as usize;
                let (task_ids, later_ids) = std::mem::take(&mut ids).split_at_mut(count);
                let (task_rows, later_rows) =
                    std::mem::take(&mut rows).split_at_mut(count * Corners::PER_TRIANGLE);
                (ids, rows) = (later_ids, later_rows);
                (nodes, task, task_rows, task_ids)
            })
            .collect();
        tasks.into_par_iter().for_each(|(nodes, task, rows, ids)| {
            let mut family = Family::default();
            let mut blocks = Blocks { begin: task[0].first_slot, used: 0, rows, ids };
            for (node, draft) in nodes.iter_mut().zip(task) {
                family.gather(self.tree, draft.root);
                self.write(node, &family, &mut blocks);
            }
        });
        nodes
    }

    fn write(&self, node: &mut Node, family: &Family, blocks: &mut Blocks) {
        for (place, &child) in family.children.iter().enumerate() {
            let bounds = self.tree.node(child).bounds();
            node.set(place, self.child(child, blocks), bounds);
        }
        node.order = self.order(family);
    }

    fn child(&self, child: u32, blocks: &mut Blocks) -> Child {
        let node = self.tree.node(child);
        if !is_leaf(self.tree, child) {
            return Child::node(node.first);
        }
        let first = node.first as usize;
        let references = &self.tree.references[first..first + node.count as usize];
        let id = references[0].id();
        if id as usize >= self.triangles.len() {
            return Child::curved(id - self.triangles.len() as u32);
        }
        let mut block = [0; 4];
        let block = &mut block[..references.len()];
        block.iter_mut().zip(references).for_each(|(id, r)| *id = r.id());
        // The first lane of several equals is then the one of the lowest id.
        block.sort_unstable();
        blocks.push(block, self.triangles)
    }

    /// The children from far to near, for each octant of directions. Of two sides of a fork the
    /// one is near whose centre comes first along the octant's diagonal.
    fn order(&self, family: &Family) -> [u32; WIDTH] {
        let count = family.children.len();
        // Four bits per octant: how many children are nearer.
        let mut nearer: [u32; WIDTH] =
            std::array::from_fn(|child| if child < count { 0 } else { 0x1111_1111 * child as u32 });
        for fork in &family.forks {
            let [left, right] = fork.sides.map(|side| self.tree.node(side).bounds());
            let apart = (right.min - left.min) + (right.max - left.max);
            let left_first = (0..8).fold(0, |word, octant| {
                word | u32::from(diagonal(octant).dot(apart) >= 0.0) << (4 * octant)
            });
            let right_first = 0x1111_1111 ^ left_first;
            for word in &mut nearer[fork.begin..fork.middle] {
                *word += right_first * (fork.end - fork.middle) as u32;
            }
            for word in &mut nearer[fork.middle..fork.end] {
                *word += left_first * (fork.middle - fork.begin) as u32;
            }
        }
        let mut order = [0; WIDTH];
        for (child, word) in nearer.iter().enumerate() {
            for octant in 0..8 {
                let from_far = 7 - (word >> (4 * octant) & 7);
                order[from_far as usize] |= (child as u32) << (4 * octant);
            }
        }
        order
    }
}

/// A direction of an octant: bit `axis` is set where it is negative.
fn diagonal(octant: u32) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|axis| if octant >> axis & 1 == 0 { 1.0 } else { -1.0 }))
}

/// The slots that one task fills.
struct Blocks<'a> {
    begin: u32,
    used: usize,
    rows: &'a mut [f32],
    ids: &'a mut [u32],
}

impl Blocks<'_> {
    fn push(&mut self, block: &[u32], triangles: &[Triangle]) -> Child {
        let slot = self.begin + self.used as u32;
        write_block(&mut self.rows[self.used * Corners::PER_TRIANGLE..], block, triangles);
        self.ids[self.used..self.used + block.len()].copy_from_slice(block);
        self.used += block.len();
        Child::triangles(slot, block.len() as u32)
    }
}

fn write_block(rows: &mut [f32], block: &[u32], triangles: &[Triangle]) {
    let n = block.len();
    for (lane, &id) in block.iter().enumerate() {
        for (corner, p) in triangles[id as usize].iter().enumerate() {
            for axis in 0..3 {
                rows[(3 * corner + axis) * n + lane] = p[axis];
            }
        }
    }
}

fn places(nodes: &[Node], ids: &[u32], slots: usize) -> Vec<Place> {
    let mut places = vec![Place::default(); ids.len()];
    for child in nodes.iter().flat_map(|node| node.children).filter(|child| child.is_block()) {
        let count = child.block_len();
        for lane in 0..count {
            let id = ids[child.index() + lane];
            places[id as usize] = Place::new(child.index() as u32, count as u32, lane as u32);
        }
    }
    for (slot, &id) in ids.iter().enumerate().skip(slots) {
        places[id as usize] = Place::new(slot as u32, 1, 0);
    }
    places
}
