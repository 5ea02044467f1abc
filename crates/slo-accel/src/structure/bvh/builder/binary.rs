//! The binary hierarchy that the wide one is made of: split by the surface area heuristic, over
//! bins where there are many primitives ([`bins`]) and over all their centres where there are few
//! ([`few`](super::few)), down to single primitives.
//!
//! A leaf costs what its blocks of primitives cost. Which subtrees become leaves and which nodes
//! melt together is planned on the way back up ([`plan`](super::plan)).

use super::bins::{self, Binning};
use super::boxes::{Box8, Reference, extent};
use super::few::{FEW, Few};
use super::heuristic::SAH_DEPTH;
use super::plan::Subtree;
use super::tree::{BinaryNode, BinaryTree, fork};
use crate::isa::Isa;

/// Builds the hierarchy; ids from `first_curved` are of curved surfaces, which never share a leaf.
/// `extent` is the box about all references and the one about their centres (Reference::center).
pub(super) fn build(
    mut references: Vec<Reference>,
    [all, centers]: [Box8; 2],
    first_curved: u32,
    isa: Isa,
) -> BinaryTree<'static> {
    let n = references.len();
    let mut nodes = vec![BinaryNode::UNBUILT; n.saturating_sub(1)];
    if n > 1 {
        let job = Job { all, centers, depth: 0, first_curved, isa };
        job.build(&mut references, &mut nodes);
    }
    BinaryTree::new(nodes, references, false)
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

    /// Sorts the primitives to both sides of a split, or halves them if there is no split.
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

/// Halves the primitives by their centres along the widest axis, the lower ids first among equals.
fn halve(references: &mut [Reference], centers: &Box8) -> usize {
    let axis = centers.size().truncate().max_position();
    let middle = references.len() / 2;
    references.select_nth_unstable_by(middle, |a, b| {
        a.center()[axis].total_cmp(&b.center()[axis]).then(a.id().cmp(&b.id()))
    });
    middle
}
