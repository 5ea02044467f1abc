//! From the planned binary hierarchy to nodes, blocks of triangles, and their ids.

use std::sync::atomic::{AtomicU32, Ordering};

use glam::Vec3;
use rayon::prelude::*;

use super::family::Family;
use super::tree::{BinaryTree, Branch};
use crate::math::Bounds;
use crate::primitives::Triangle;
use crate::structure::bvh::layout::{
    BLOCK, Child, Corners, FIRST_CHANGE, ID_ROW, Node, Place, WIDTH, nodes_per_node, rows_of,
};
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

/// The triangles that leaves hold.
pub(super) struct Shapes<'a> {
    pub(super) starts: &'a [Triangle],
    /// Where they move to, if they do.
    pub(super) ends: Option<&'a [Triangle]>,
}

impl Shapes<'_> {
    /// The boxes about a triangle at the start and at the end.
    pub(super) fn boxes(&self, id: u32) -> [Bounds; 2] {
        let ends = self.ends.unwrap_or(self.starts);
        [self.starts, ends].map(|triangles| Bounds::of_points(triangles[id as usize]))
    }

    fn moves(&self) -> bool {
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
    let mut corners = Corners::new(slots + left_out.len(), shapes.moves());
    let (leaf_rows, other_rows) = corners.rows_mut().split_at_mut(slots * shapes.rows());
    let places =
        (0..shapes.starts.len()).into_par_iter().map(|_| AtomicU32::new(u32::MAX)).collect();
    let writer = Writer { tree: &tree, shapes, places };
    let nodes = writer.write_all(&drafts, leaf_rows);
    let mut others = Blocks { begin: slots as u32, used: 0, rows: other_rows };
    for &id in left_out {
        others.push(&[id], &writer);
    }
    let places = writer.places.into_iter().map(|place| Place(place.into_inner())).collect();
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
            } else if tree.references[child.first as usize].id() < first_curved {
                slots += block_len(tree, child);
            }
        }
    }
    (drafts, slots as usize, depth)
}

struct Writer<'a> {
    tree: &'a BinaryTree,
    shapes: &'a Shapes<'a>,
    /// Where each triangle was put, by id.
    places: Vec<AtomicU32>,
}

impl Writer<'_> {
    fn write_all(&self, drafts: &[Draft], mut rows: &mut [f32]) -> Array<Node> {
        let (per_node, per_triangle) = (nodes_per_node(self.shapes.moves()), self.shapes.rows());
        let mut nodes = Array::filled(Node::EMPTY, per_node * drafts.len());
        let slots = (rows.len() / per_triangle) as u32;
        let tasks: Vec<_> = nodes
            .chunks_mut(per_node * TASK)
            .zip(drafts.chunks(TASK))
            .enumerate()
            .map(|(i, (nodes, task))| {
                let end = drafts.get((i + 1) * TASK).map_or(slots, |next| next.first_slot);
                let count = (end - task[0].first_slot) as usize;
                let (task_rows, later_rows) =
                    std::mem::take(&mut rows).split_at_mut(count * per_triangle);
                rows = later_rows;
                (nodes, task, task_rows)
            })
            .collect();
        tasks.into_par_iter().for_each(|(nodes, task, rows)| {
            let mut family = Family::default();
            let mut blocks = Blocks { begin: task[0].first_slot, used: 0, rows };
            for (nodes, draft) in nodes.chunks_exact_mut(per_node).zip(task) {
                family.gather(self.tree, draft.root);
                self.write(nodes, &family, &mut blocks);
            }
        });
        nodes
    }

    /// Notes the place of a triangle; the lowest one if there are several, in any order of tasks.
    fn put(&self, id: u32, place: Place) {
        let known = &self.places[id as usize];
        if self.tree.has_pieces {
            known.fetch_min(place.0, Ordering::Relaxed);
        } else {
            known.store(place.0, Ordering::Relaxed);
        }
    }

    fn write(&self, nodes: &mut [Node], family: &Family, blocks: &mut Blocks) {
        if self.shapes.moves() {
            nodes[1] = Node::AT_REST;
        }
        for (place, &branch) in family.children.iter().enumerate() {
            let child = self.child(branch, blocks);
            if self.shapes.moves() {
                Node::set_moving(nodes, place, child, self.moving_boxes(branch));
            } else {
                nodes[0].set(place, child, self.tree.bounds(branch));
            }
        }
        nodes[0].order = self.order(family);
    }

    /// The boxes about a branch at the start and at the end. What moves straight from one to the
    /// other stays between the planes that do, so both are as tight as they can be.
    fn moving_boxes(&self, of: Branch) -> [Bounds; 2] {
        let references = &self.tree.references[of.first as usize..][..of.count as usize];
        references
            .iter()
            .map(|r| self.shapes.boxes(r.id()))
            .fold([Bounds::EMPTY; 2], |[start, end], [a, b]| [start.union(a), end.union(b)])
    }

    fn child(&self, child: Branch, blocks: &mut Blocks) -> Child {
        if !self.tree.is_leaf(child) {
            let per_node = nodes_per_node(self.shapes.moves()) as u32;
            return Child::node(per_node * self.tree.plan(child).number());
        }
        let id = self.tree.references[child.first as usize].id();
        let triangles = self.shapes.starts.len();
        if id as usize >= triangles {
            return Child::curved(id - triangles as u32);
        }
        blocks.push(Block::of(self.tree, child).ids(), self)
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
        let (first, mut len) = (leaf.first as usize, leaf.count as usize);
        let mut ids = [0; BLOCK];
        let references = &tree.references[first..first + len];
        ids.iter_mut().zip(references).for_each(|(id, r)| *id = r.id());
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
    rows: &'a mut [f32],
}

impl Blocks<'_> {
    fn push(&mut self, block: &[u32], writer: &Writer) -> Child {
        let (slot, count) = (self.begin + self.used as u32, block.len() as u32);
        writer.shapes.write(&mut self.rows[self.used * writer.shapes.rows()..], block);
        for (lane, &id) in (0..).zip(block) {
            writer.put(id, Place::new(slot, count, lane));
        }
        self.used += block.len();
        Child::triangles(slot, count)
    }
}
