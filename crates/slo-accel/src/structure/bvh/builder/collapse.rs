//! From the planned binary hierarchy to nodes, blocks of triangles, and their ids.

use glam::Vec3;
use rayon::prelude::*;

use super::family::Family;
use super::fit::fit;
use super::rows::{self, Shapes};
use super::tree::{BinaryTree, Branch};
use crate::structure::bvh::layout::{BLOCK, Child, Corners, Node, Place, WIDTH, nodes_per_node};
use crate::structure::shared::pages::Array;

/// Wide nodes that one task writes.
const TASK: usize = 256;

/// The parts of a finished hierarchy.
pub(super) struct Wide {
    pub(super) nodes: Array<Node>,
    pub(super) corners: Corners,
    /// Where each triangle is first, by id.
    pub(super) places: Vec<Place>,
    /// How many nodes there are from the root to the deepest, both counted.
    pub(super) depth: usize,
}

/// A wide node to be written.
#[derive(Clone, Copy)]
struct Draft {
    /// The branch that it represents.
    root: Branch,
    first_slot: u32,
}

/// Writes the wide hierarchy; `left_out` are triangles without area, which get a place but no leaf.
pub(super) fn collapse(mut tree: BinaryTree, shapes: &Shapes, left_out: &[u32]) -> Wide {
    let (drafts, slots, depth) = draft(&mut tree, shapes.starts.len() as u32);
    let mut ids = Vec::with_capacity(slots + left_out.len());
    ids.resize(slots, 0);
    let mut nodes = Writer { tree: &tree, shapes }.write_all(&drafts, &mut ids);
    if shapes.moves() {
        fit(&mut nodes, shapes, &ids);
    }
    ids.extend(left_out);
    // The corners take the place of what is not needed any more.
    let has_pieces = tree.has_pieces;
    drop((tree, drafts));
    let (corners, places) = rows::fill(shapes, &nodes, (&ids, slots), has_pieces);
    Wide { nodes, corners, places, depth }
}

/// Numbers the wide nodes, parents before children and subtrees together; the plan of each binary
/// node that becomes one holds its number afterwards. Also the slots used and the depth.
fn draft(tree: &mut BinaryTree, first_curved: u32) -> (Vec<Draft>, usize, usize) {
    let mut drafts = Vec::new();
    let (mut slots, mut depth) = (0, 0);
    let mut family = Family::default();
    let mut stack: Vec<(Branch, usize)> = tree.root().map(|root| (root, 1)).into_iter().collect();
    while let Some((root, level)) = stack.pop() {
        depth = depth.max(level);
        family.gather(tree, root);
        if root.count > 1 {
            tree.plan_mut(root).set_number(drafts.len() as u32);
        }
        drafts.push(Draft { root, first_slot: slots });
        for &child in family.children.iter().rev() {
            if !tree.is_leaf(child) {
                stack.push((child, level + 1));
            } else if tree.id(child.first) < first_curved {
                slots += block_len(tree, child);
            }
        }
    }
    (drafts, slots as usize, depth)
}

struct Writer<'a> {
    tree: &'a BinaryTree<'a>,
    shapes: &'a Shapes<'a>,
}

impl Writer<'_> {
    /// Writes all nodes, and the ids of triangles by slot.
    fn write_all(&self, drafts: &[Draft], mut ids: &mut [u32]) -> Array<Node> {
        let per_node = nodes_per_node(self.shapes.moves());
        let mut nodes = Array::filled(Node::EMPTY, per_node * drafts.len());
        let slots = ids.len() as u32;
        let tasks: Vec<_> = nodes
            .chunks_mut(per_node * TASK)
            .zip(drafts.chunks(TASK))
            .enumerate()
            .map(|(i, (nodes, task))| {
                let end = drafts.get((i + 1) * TASK).map_or(slots, |next| next.first_slot);
                let count = (end - task[0].first_slot) as usize;
                let (of_task, later) = std::mem::take(&mut ids).split_at_mut(count);
                ids = later;
                (nodes, task, of_task)
            })
            .collect();
        tasks.into_par_iter().for_each(|(nodes, task, ids)| {
            let mut family = Family::default();
            let mut blocks = Blocks { begin: task[0].first_slot, used: 0, ids };
            for (nodes, draft) in nodes.chunks_exact_mut(per_node).zip(task) {
                family.gather(self.tree, draft.root);
                self.write(nodes, &family, &mut blocks);
            }
        });
        nodes
    }

    fn write(&self, nodes: &mut [Node], family: &Family, blocks: &mut Blocks) {
        for (place, &branch) in family.children.iter().enumerate() {
            let child = self.child(branch, blocks);
            if self.shapes.moves() {
                nodes[0].children[place] = child;
            } else {
                nodes[0].set(place, child, self.tree.bounds(branch));
            }
        }
        nodes[0].order = self.order(family);
    }

    fn child(&self, child: Branch, blocks: &mut Blocks) -> Child {
        if !self.tree.is_leaf(child) {
            let per_node = nodes_per_node(self.shapes.moves()) as u32;
            return Child::node(per_node * self.tree.plan(child).number());
        }
        let id = self.tree.id(child.first);
        let triangles = self.shapes.starts.len();
        if id as usize >= triangles {
            return Child::curved(id - triangles as u32);
        }
        blocks.push(Block::of(self.tree, child).ids())
    }

    /// The children from far to near, for each octant of directions. Of two sides of a fork the
    /// one is near whose centre comes first along the octant's diagonal.
    fn order(&self, family: &Family) -> [u32; WIDTH] {
        let count = family.children.len();
        // Four bits per octant: how many children are nearer.
        let mut nearer: [u32; WIDTH] =
            std::array::from_fn(|child| if child < count { 0 } else { 0x1111_1111 * child as u32 });
        for fork in &family.forks {
            let [left, right] = fork.sides.map(|side| self.tree.bounds(side));
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

/// A direction of an octant: bit `axis` of `octant` is set if it is negative.
fn diagonal(octant: u32) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|axis| if octant >> axis & 1 == 0 { 1.0 } else { -1.0 }))
}

/// Number of triangles of a leaf.
fn block_len(tree: &BinaryTree, leaf: Branch) -> u32 {
    if tree.has_pieces { Block::of(tree, leaf).len as u32 } else { leaf.count }
}

/// The triangles of a leaf, each once.
struct Block {
    ids: [u32; BLOCK],
    len: usize,
}

impl Block {
    fn of(tree: &BinaryTree, leaf: Branch) -> Self {
        let (mut ids, mut len) = ([0; BLOCK], leaf.count as usize);
        ids.iter_mut().zip(tree.ids(leaf)).for_each(|(to, id)| *to = id);
        // The first lane of several equals is then the one of the lowest id.
        ids[..len].sort_unstable();
        if tree.has_pieces {
            len = without_repeats(&mut ids[..len]);
        }
        Self { ids, len }
    }

    fn ids(&self) -> &[u32] {
        &self.ids[..self.len]
    }
}

/// Moves the distinct ones of sorted ids to the front; returns their number.
fn without_repeats(ids: &mut [u32]) -> usize {
    let mut len = 1;
    for i in 1..ids.len() {
        if ids[i] != ids[len - 1] {
            ids[len] = ids[i];
            len += 1;
        }
    }
    len
}

/// The slots that one task fills.
struct Blocks<'a> {
    begin: u32,
    used: usize,
    ids: &'a mut [u32],
}

impl Blocks<'_> {
    fn push(&mut self, block: &[u32]) -> Child {
        let slot = self.begin + self.used as u32;
        self.ids[self.used..][..block.len()].copy_from_slice(block);
        self.used += block.len();
        Child::triangles(slot, block.len() as u32)
    }
}
