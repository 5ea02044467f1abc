//! A binary hierarchy: objects are sorted along the longest axis of their box and halved.
//!
//! Source: Kay, Kajiya, *Ray Tracing Complex Scenes*, SIGGRAPH 1986. It departs from it: the axis is
//! the longest of the node's box instead of each in turn, and objects are sorted by the centres of
//! their boxes.

use super::hierarchy::{Builder, Plan};
use super::parameters::Parameters;

/// Builds by halves.
#[derive(Debug)]
pub struct Median;

/// Objects of a leaf, if not given.
const LEAF: u32 = 4;

impl Builder for Median {
    fn build(plan: &mut Plan<'_>, mut ids: Vec<u32>, parameters: &Parameters) {
        let leaf = parameters.leaf.unwrap_or(LEAF).max(1) as usize;
        let depth = parameters.depth.unwrap_or(u32::MAX);
        let root = plan.add(1);
        split(plan, root, &mut ids, leaf, depth);
    }
}

fn split(plan: &mut Plan<'_>, node: usize, ids: &mut [u32], leaf: usize, depth: u32) {
    if ids.len() <= leaf || depth == 0 {
        return plan.set_leaf(node, ids);
    }
    let size = plan.bounds(ids).size();
    let longest = (0..3).fold(0, |best, axis| if size[axis] > size[best] { axis } else { best });
    plan.sort(ids, longest);
    let first = plan.add(2);
    plan.set_children(node, first, 2, ids);
    let (left, right) = ids.split_at_mut(ids.len() / 2);
    split(plan, first, left, leaf, depth - 1);
    split(plan, first + 1, right, leaf, depth - 1);
}
