//! The binary hierarchy that the wide one is made of: split by the surface area heuristic, over
//! bins where there are many primitives ([`bins`]) and over all their centres where there are few
//! ([`few`](super::few)), down to single primitives.
//!
//! A leaf costs what its blocks of [`BLOCK`] primitives cost. Which subtrees become leaves and
//! which nodes melt together is planned on the way back up ([`plan`]).

use glam::Vec3;

use super::bins::{self, Binning};
use super::boxes::{Box8, Reference};
use super::few::{FEW, Few};
use super::plan::{self, Plan, Subtree};
use crate::Isa;
use crate::math::Bounds;

/// Primitives that one step tests together.
pub(super) const BLOCK: usize = 4;

/// Below this depth nodes are halved, so that no input gives more than `SAH_DEPTH + 32` levels.
pub(super) const SAH_DEPTH: u32 = 48;

/// Subtrees with more primitives are worth a task of their own.
pub(super) const PARALLEL_SUBTREE: usize = 2048;

/// An inner node of the binary hierarchy, stored before those below it. Over n primitives there are
/// n - 1: the root, then those of its left side, then those of its right side.
#[derive(Clone, Copy, Debug)]
pub(super) struct BinaryNode {
    min: Vec3,
    /// How many primitives lie on the left side.
    left: u32,
    max: Vec3,
    /// What becomes of it in the wide hierarchy.
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
    /// Where its primitives begin in the order of leaves.
    pub(super) first: u32,
    /// How many primitives it has, from 1.
    pub(super) count: u32,
    /// Its root, where there is more than one primitive.
    node: u32,
}

/// A binary hierarchy with its plan.
pub(super) struct BinaryTree {
    /// The inner nodes, the root first.
    pub(super) nodes: Vec<BinaryNode>,
    /// The primitives in the order of leaves.
    pub(super) references: Vec<Reference>,
    /// Whether there may be several references to a triangle.
    pub(super) has_pieces: bool,
}

impl BinaryTree {
    /// Builds the hierarchy; ids from `first_curved` are of curved surfaces, which never share a
    /// leaf. `extent` is the box about all references and the one about their centres
    /// (Reference::center).
    pub(super) fn build(
        mut references: Vec<Reference>,
        [all, centers]: [Box8; 2],
        first_curved: u32,
        isa: Isa,
    ) -> Self {
        let n = references.len();
        let mut nodes = vec![BinaryNode::UNBUILT; n.saturating_sub(1)];
        if n > 1 {
            let job = Job { all, centers, depth: 0, first_curved, isa };
            job.build(&mut references, &mut nodes);
        }
        Self { nodes, references, has_pieces: false }
    }

    /// All of it; none where there are no primitives.
    pub(super) fn root(&self) -> Option<Branch> {
        let count = self.references.len() as u32;
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
        if of.count == 1 {
            self.references[of.first as usize].bounds().bounds()
        } else {
            let node = &self.nodes[of.node as usize];
            Bounds { min: node.min, max: node.max }
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

    /// Whether a branch becomes a leaf where it stands alone.
    pub(super) fn is_leaf(&self, of: Branch) -> bool {
        of.count == 1 || self.plan(of).is_leaf()
    }
}

/// One subtree to be built.
pub(super) struct Job {
    pub(super) all: Box8,
    pub(super) centers: Box8,
    pub(super) depth: u32,
    pub(super) first_curved: u32,
    pub(super) isa: Isa,
}

impl Job {
    pub(super) fn build(self, references: &mut [Reference], nodes: &mut [BinaryNode]) -> Subtree {
        let n = references.len();
        if n <= FEW {
            return Few::build(
                references,
                nodes,
                self.all,
                self.depth,
                self.first_curved,
                self.isa,
            );
        }
        let (middle, [left, right]) = self.split(references);
        fork(
            &self.all,
            middle,
            (references, nodes),
            |references, nodes| left.build(references, nodes),
            |references, nodes| right.build(references, nodes),
        )
    }

    /// Sorts the primitives to both sides of the best split.
    fn split(&self, references: &mut [Reference]) -> (usize, [Job; 2]) {
        let binning = Binning::new(&self.centers);
        let best = if self.depth < SAH_DEPTH {
            bins::best_split(&binning, references, self.isa)
        } else {
            None
        };
        self.split_at(references, &binning, best)
    }

    /// Sorts the primitives to both sides of a split, or halves them where there is none.
    pub(super) fn split_at(
        &self,
        references: &mut [Reference],
        binning: &Binning,
        best: Option<bins::Split>,
    ) -> (usize, [Job; 2]) {
        if let Some(split) = best {
            let (middle, centers) = bins::partition(references, binning, &split, self.isa);
            if 0 < middle && middle < references.len() {
                return (middle, self.children(split.sides, centers));
            }
        }
        let middle = halve(references, &self.centers);
        let (left, right) = (extent(&references[..middle]), extent(&references[middle..]));
        (middle, self.children([left[0], right[0]], [left[1], right[1]]))
    }

    /// The jobs of both sides, by the boxes about their primitives and about the centres.
    pub(super) fn children(&self, all: [Box8; 2], centers: [Box8; 2]) -> [Job; 2] {
        [0, 1].map(|side| Job {
            all: all[side],
            centers: centers[side],
            depth: self.depth + 1,
            first_curved: self.first_curved,
            isa: self.isa,
        })
    }
}

/// Builds both sides of a node about `all`, of which `middle` primitives are left.
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

/// Boxes about references and about their [centres](Reference::center).
pub(super) fn extent(references: &[Reference]) -> [Box8; 2] {
    references.iter().fold([Box8::EMPTY; 2], |[all, centers], r| {
        [all.union(r.bounds()), centers.union(&Box8::point(r.center()))]
    })
}

/// Halves the primitives by their centres along the widest axis, the lower ids first among equals.
fn halve(references: &mut [Reference], centers: &Box8) -> usize {
    let axis = centers.size().truncate().max_position();
    let middle = references.len() / 2;
    references.select_nth_unstable_by(middle, |a, b| {
        a.center()[axis].total_cmp(&b.center()[axis]).then(a.id().cmp(&b.id()))
    });
    middle
}

/// What a side of a split costs; infinite for an empty one, so that no split has one.
#[inline(always)]
pub(super) fn cost(half_area: f32, count: u32) -> f32 {
    if count == 0 { f32::INFINITY } else { half_area * count.div_ceil(BLOCK as u32) as f32 }
}
