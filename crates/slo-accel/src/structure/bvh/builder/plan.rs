//! Which nodes of the binary hierarchy become nodes of the wide one, which melt away, and which
//! become leaves: the cheapest by the surface area heuristic, found by dynamic programming.
//!
//! Source: Ylitie, Karras, Laine, *Efficient Incoherent Ray Traversal on GPUs Through Compressed
//! Wide BVHs* (HPG 2017), section 2; here a leaf costs by blocks, and curved surfaces cost more.

use super::heuristic::{CURVED_COST, NODE_COST};
use crate::structure::bvh::layout::{BLOCK, WIDTH};

/// The fate of a binary node: for each number of roots `j` from 2 to 8 that its subtree may take, 3
/// bits with the number that the left child gets, 0 if one root fewer is as cheap; and whether the
/// node is a leaf if it is a root itself.
///
/// A node of the wide hierarchy only needs the share of eight roots: its number replaces the
/// others.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan(u32);

impl Plan {
    const IS_NUMBERED: u32 = 1 << 31;
    const IS_LEAF: u32 = 1 << 27;
    const ALL_ROOTS: u32 = 28;
    const NUMBER: u32 = (1 << Self::ALL_ROOTS) - 1;

    /// A leaf wherever it stands.
    pub(super) const LEAF: Self = Self(Self::IS_LEAF);

    pub(super) fn is_leaf(self) -> bool {
        self.0 & (Self::IS_NUMBERED | Self::IS_LEAF) == Self::IS_LEAF
    }

    /// See [`Plan`]; a node of the wide hierarchy takes all roots or one.
    pub(super) fn left_roots(self, roots: usize) -> usize {
        let shift = match roots {
            WIDTH => Self::ALL_ROOTS,
            _ if self.0 & Self::IS_NUMBERED != 0 => return 0,
            _ => 3 * (roots as u32 - 2),
        };
        (self.0 >> shift) as usize & 7
    }

    /// Keeps the number of a wide node.
    pub(super) fn set_number(&mut self, number: u32) {
        self.0 = Self::IS_NUMBERED | self.0 & (7 << Self::ALL_ROOTS) | number;
    }

    /// The number of a wide node.
    pub(super) fn number(self) -> u32 {
        self.0 & Self::NUMBER
    }
}

/// Costs of a subtree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Subtree {
    /// By the number of roots that it may take, from 1.
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

/// The cheapest ways to represent a node over `count` primitives and two children.
pub(super) fn combine(
    half_area: f32,
    count: usize,
    left: &Subtree,
    right: &Subtree,
) -> (Subtree, Plan) {
    let has_curved = left.has_curved || right.has_curved;
    let (mut costs, to_left) = distribute(&left.costs, &right.costs);
    let inner = NODE_COST * half_area + costs[WIDTH - 1];
    let is_leaf = count <= BLOCK && !has_curved && half_area <= inner;
    costs[0] = if is_leaf { half_area } else { inner };
    let mut plan = u32::from(is_leaf) * Plan::IS_LEAF;
    // Eight roots are always shared out: they are the children of a node.
    for roots in 2..WIDTH {
        let is_cheaper = costs[roots - 1] < costs[roots - 2];
        costs[roots - 1] = if is_cheaper { costs[roots - 1] } else { costs[roots - 2] };
        plan |= (u32::from(is_cheaper) * to_left[roots - 1]) << (3 * (roots - 2));
    }
    costs[WIDTH - 1] = costs[WIDTH - 1].min(costs[WIDTH - 2]);
    plan |= to_left[WIDTH - 1] << Plan::ALL_ROOTS;
    (Subtree { costs, has_curved }, Plan(plan))
}

/// The cheapest ways to share 2 to [`WIDTH`] roots between both children, and the numbers on the
/// left.
#[inline(always)]
fn distribute(left: &[f32; WIDTH], right: &[f32; WIDTH]) -> ([f32; WIDTH], [u32; WIDTH]) {
    // The right child's costs behind infinite ones, so that all numbers of roots are tried at once.
    let mut shifted = [f32::INFINITY; 2 * WIDTH];
    shifted[WIDTH..].copy_from_slice(right);
    let mut costs = [f32::INFINITY; WIDTH];
    let mut to_left = [1; WIDTH];
    for given in 1..WIDTH {
        let right = &shifted[WIDTH - given..][..WIDTH];
        for i in 0..WIDTH {
            let cost = left[given - 1] + right[i];
            let is_cheaper = cost < costs[i];
            costs[i] = if is_cheaper { cost } else { costs[i] };
            to_left[i] = if is_cheaper { given as u32 } else { to_left[i] };
        }
    }
    (costs, to_left)
}
