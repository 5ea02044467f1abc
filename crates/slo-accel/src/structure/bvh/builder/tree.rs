//! The binary hierarchy, from which the wide one is made.

use glam::Vec3;

use super::boxes::{Box8, Reference};
use super::plan::{self, Plan, Subtree};
use crate::math::Bounds;

/// Subtrees with more primitives are built by tasks of their own.
pub(super) const PARALLEL_SUBTREE: usize = 2048;

/// An inner node of the binary hierarchy, stored before those below it. Over n primitives there are
/// n - 1: the root, then those of its left side, then those of its right side.
#[derive(Clone, Copy, Debug)]
pub(super) struct BinaryNode {
    min: Vec3,
    /// How many primitives lie on the left side.
    left: u32,
    max: Vec3,
    /// Its fate in the wide hierarchy.
    pub(super) plan: Plan,
}

impl BinaryNode {
    pub(super) const UNBUILT: Self =
        Self { min: Vec3::ZERO, left: 0, max: Vec3::ZERO, plan: Plan::LEAF };

    #[inline(always)]
    pub(super) fn new(all: &Box8, left: usize, plan: Plan) -> Self {
        let Bounds { min, max } = all.bounds();
        Self { min, left: left as u32, max, plan }
    }
}

/// A subtree of a [`BinaryTree`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Branch {
    /// Index of its first primitive in the order of leaves.
    pub(super) first: u32,
    /// How many primitives it has, from 1.
    pub(super) count: u32,
    /// Its root, if it has more than one primitive.
    node: u32,
}

/// A binary hierarchy with its plan.
pub(super) struct BinaryTree<'a> {
    /// The inner nodes, the root first.
    nodes: Vec<BinaryNode>,
    leaves: Leaves<'a>,
    /// Whether there may be several references to a triangle.
    pub(super) has_pieces: bool,
}

/// The primitives in the order of leaves.
enum Leaves<'a> {
    References(Vec<Reference>),
    /// Their ids, and their boxes by id.
    Ids(Vec<u32>, &'a (dyn Fn(u32) -> Bounds + Sync)),
}

impl<'a> BinaryTree<'a> {
    pub(super) fn new(
        nodes: Vec<BinaryNode>,
        references: Vec<Reference>,
        has_pieces: bool,
    ) -> Self {
        Self { nodes, leaves: Leaves::References(references), has_pieces }
    }

    /// Forgets the boxes of primitives, which `bounds` finds again by the ids. They are those of
    /// whole primitives.
    pub(super) fn forget_boxes(&mut self, bounds: &'a (dyn Fn(u32) -> Bounds + Sync)) {
        if let (Leaves::References(references), false) = (&self.leaves, self.has_pieces) {
            self.leaves = Leaves::Ids(references.iter().map(Reference::id).collect(), bounds);
        }
    }

    /// How many primitives there are, with pieces.
    fn len(&self) -> usize {
        match &self.leaves {
            Leaves::References(references) => references.len(),
            Leaves::Ids(ids, _) => ids.len(),
        }
    }

    /// The id of a primitive by its place in the order of leaves.
    #[inline]
    pub(super) fn id(&self, place: u32) -> u32 {
        match &self.leaves {
            Leaves::References(references) => references[place as usize].id(),
            Leaves::Ids(ids, _) => ids[place as usize],
        }
    }

    /// The ids of the primitives of a branch.
    pub(super) fn ids(&self, of: Branch) -> impl Iterator<Item = u32> {
        (of.first..of.first + of.count).map(|place| self.id(place))
    }

    /// The whole hierarchy; none if it has no primitives.
    pub(super) fn root(&self) -> Option<Branch> {
        let count = self.len() as u32;
        (count > 0).then_some(Branch { first: 0, count, node: 0 })
    }

    /// Both sides of more than one primitive.
    pub(super) fn children(&self, of: Branch) -> [Branch; 2] {
        let left = self.nodes[of.node as usize].left;
        [
            Branch { first: of.first, count: left, node: of.node + 1 },
            Branch { first: of.first + left, count: of.count - left, node: of.node + left },
        ]
    }

    /// The box about the primitives of a branch.
    pub(super) fn bounds(&self, of: Branch) -> Bounds {
        if of.count > 1 {
            let node = &self.nodes[of.node as usize];
            return Bounds { min: node.min, max: node.max };
        }
        match &self.leaves {
            Leaves::References(references) => references[of.first as usize].bounds().bounds(),
            Leaves::Ids(ids, bounds) => bounds(ids[of.first as usize]),
        }
    }

    /// The plan of more than one primitive.
    pub(super) fn plan(&self, of: Branch) -> Plan {
        self.nodes[of.node as usize].plan
    }

    /// See [`plan`](Self::plan).
    pub(super) fn plan_mut(&mut self, of: Branch) -> &mut Plan {
        &mut self.nodes[of.node as usize].plan
    }

    /// Whether a branch that is a root becomes a leaf.
    pub(super) fn is_leaf(&self, of: Branch) -> bool {
        of.count == 1 || self.plan(of).is_leaf()
    }
}

/// Builds both sides of a node about `all`; the first `middle` primitives are on the left.
pub(super) fn fork(
    all: &Box8,
    middle: usize,
    (references, nodes): (&mut [Reference], &mut [BinaryNode]),
    left: impl FnOnce(&mut [Reference], &mut [BinaryNode]) -> Subtree + Send,
    right: impl FnOnce(&mut [Reference], &mut [BinaryNode]) -> Subtree + Send,
) -> Subtree {
    let n = references.len();
    let (node, below) = nodes.split_first_mut().expect("n - 1 nodes for n primitives");
    let (left_refs, right_refs) = references.split_at_mut(middle);
    let (left_nodes, right_nodes) = below.split_at_mut(middle - 1);
    let build_left = || left(left_refs, left_nodes);
    let build_right = || right(right_refs, right_nodes);
    let (left, right) = if n > PARALLEL_SUBTREE {
        rayon::join(build_left, build_right)
    } else {
        (build_left(), build_right())
    };
    let (subtree, plan) = plan::combine(all.half_area(), n, &left, &right);
    *node = BinaryNode::new(all, middle, plan);
    subtree
}
