//! Which nodes of the binary hierarchy become nodes of the wide one, which melt away, and which
//! become leaves: the cheapest by the surface area heuristic, found by dynamic programming.
//!
//! Source: Ylitie, Karras, Laine, *Efficient Incoherent Ray Traversal on GPUs Through Compressed
//! Wide BVHs* (HPG 2017), section 2; here a leaf costs by blocks, and curved surfaces cost more.

use super::binary::{BLOCK, BinaryTree};
use super::layout::WIDTH;

/// Cost of testing the boxes of a node, in tests of a block of triangles.
const NODE_COST: f32 = 1.0;

/// Cost of testing a curved surface, in tests of a block of triangles.
const CURVED_COST: f32 = 4.0;

/// What becomes of a binary node: 3 bits for each number of roots `j` from 2 to 8 that its subtree
/// may take, telling how many of them go to the left child, 0 if one root fewer is as cheap; and
/// whether it is a leaf where it is a root itself.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan(u32);

impl Plan {
    const IS_LEAF: u32 = 1 << 31;

    /// A leaf wherever it stands.
    pub(super) const LEAF: Self = Self(Self::IS_LEAF);

    pub(super) fn is_leaf(self) -> bool {
        self.0 & Self::IS_LEAF != 0
    }

    fn left_roots(self, roots: usize) -> usize {
        (self.0 >> (3 * (roots - 2))) as usize & 7
    }
}

/// What a subtree costs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Subtree {
    /// By how many roots it may take, from 1.
    costs: [f32; WIDTH],
    has_curved: bool,
}

impl Subtree {
    /// One primitive.
    pub(super) fn single(half_area: f32, is_curved: bool) -> Self {
        let cost = half_area * if is_curved { CURVED_COST } else { 1.0 };
        Self { costs: [cost; WIDTH], has_curved: is_curved }
    }
}

/// The cheapest ways to stand for a node over `count` primitives and two children.
pub(super) fn combine(
    half_area: f32,
    count: u32,
    left: &Subtree,
    right: &Subtree,
) -> (Subtree, Plan) {
    let has_curved = left.has_curved || right.has_curved;
    let mut costs = [0.0; WIDTH];
    let mut plan = 0;
    for roots in 2..=WIDTH {
        let (cost, to_left) = distribute(left, right, roots);
        costs[roots - 1] = cost;
        plan |= (to_left as u32) << (3 * (roots - 2));
    }
    let inner = NODE_COST * half_area + costs[WIDTH - 1];
    costs[0] = inner;
    if count as usize <= BLOCK && !has_curved && half_area <= inner {
        costs[0] = half_area;
        plan |= Plan::IS_LEAF;
    }
    // Eight roots are always shared out: they are the children of a node.
    for roots in 2..WIDTH {
        if costs[roots - 2] <= costs[roots - 1] {
            costs[roots - 1] = costs[roots - 2];
            plan &= !(7 << (3 * (roots - 2)));
        }
    }
    costs[WIDTH - 1] = costs[WIDTH - 1].min(costs[WIDTH - 2]);
    (Subtree { costs, has_curved }, Plan(plan))
}

/// The cheapest way to share `roots` between both children, and how many go left.
fn distribute(left: &Subtree, right: &Subtree, roots: usize) -> (f32, usize) {
    let mut best = (f32::INFINITY, 1);
    for to_left in 1..roots {
        let cost = left.costs[to_left - 1] + right.costs[roots - to_left - 1];
        if cost < best.0 {
            best = (cost, to_left);
        }
    }
    best
}

/// Two neighbouring runs of a wide node's children that a binary node told apart.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fork {
    /// The binary nodes of both sides.
    pub(super) sides: [u32; 2],
    /// Left children are `begin..middle`, right ones `middle..end`.
    pub(super) begin: usize,
    /// See `begin`.
    pub(super) middle: usize,
    /// See `begin`.
    pub(super) end: usize,
}

/// The children of a wide node, as binary nodes, and how they are told apart.
#[derive(Debug, Default)]
pub(super) struct Family {
    pub(super) children: Vec<u32>,
    pub(super) forks: Vec<Fork>,
}

impl Family {
    /// Becomes the family of the wide node that stands for the binary node `root`.
    pub(super) fn gather(&mut self, tree: &BinaryTree, root: u32) {
        self.children.clear();
        self.forks.clear();
        if tree.node(root).count == 1 {
            self.children.push(root);
        } else {
            self.fork(tree, root, WIDTH);
        }
    }

    fn add(&mut self, tree: &BinaryTree, node: u32, roots: usize) {
        let plan = tree.node(node).plan;
        let is_single = tree.node(node).count == 1;
        if roots == 1 || is_single {
            self.children.push(node);
        } else if roots < WIDTH && plan.left_roots(roots) == 0 {
            self.add(tree, node, roots - 1);
        } else {
            self.fork(tree, node, roots);
        }
    }

    fn fork(&mut self, tree: &BinaryTree, node: u32, roots: usize) {
        let sides = tree.children(node);
        let to_left = tree.node(node).plan.left_roots(roots);
        let begin = self.children.len();
        self.add(tree, sides[0], to_left);
        let middle = self.children.len();
        self.add(tree, sides[1], roots - to_left);
        self.forks.push(Fork { sides, begin, middle, end: self.children.len() });
    }
}
