//! The children of wide nodes, as the [plan](super::plan) has them.

use super::tree::{BinaryTree, Branch};
use crate::structure::bvh::layout::WIDTH;

/// Two adjacent runs of a wide node's children, which a binary node separates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fork {
    /// Both sides.
    pub(super) sides: [Branch; 2],
    /// Left children are `begin..middle`, right ones `middle..end`.
    pub(super) begin: usize,
    /// See `begin`.
    pub(super) middle: usize,
    /// See `begin`.
    pub(super) end: usize,
}

/// The children of a wide node, and the forks that separate them.
#[derive(Debug, Default)]
pub(super) struct Family {
    pub(super) children: Vec<Branch>,
    pub(super) forks: Vec<Fork>,
}

impl Family {
    /// Fills in the family of the wide node that represents `root`.
    pub(super) fn gather(&mut self, tree: &BinaryTree, root: Branch) {
        self.children.clear();
        self.forks.clear();
        if root.count == 1 {
            self.children.push(root);
        } else {
            self.fork(tree, root, WIDTH);
        }
    }

    fn add(&mut self, tree: &BinaryTree, branch: Branch, mut roots: usize) {
        if branch.count > 1 {
            let plan = tree.plan(branch);
            while roots > 1 && plan.left_roots(roots) == 0 {
                roots -= 1;
            }
            if roots > 1 {
                return self.fork(tree, branch, roots);
            }
        }
        self.children.push(branch);
    }

    fn fork(&mut self, tree: &BinaryTree, branch: Branch, roots: usize) {
        let sides = tree.children(branch);
        let to_left = tree.plan(branch).left_roots(roots);
        let begin = self.children.len();
        self.add(tree, sides[0], to_left);
        let middle = self.children.len();
        self.add(tree, sides[1], roots - to_left);
        self.forks.push(Fork { sides, begin, middle, end: self.children.len() });
    }
}
