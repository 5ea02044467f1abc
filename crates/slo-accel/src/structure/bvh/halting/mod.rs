//! A hierarchy over boxes, whose rays halt before each box that they enter: the upper level of a
//! structure of structures.
//!
//! All rays of a batch go on until each has come to a box, or to its end. The caller then asks what
//! is in the boxes, tells which rays have become shorter, and lets them go on. So there is no list
//! of boxes for a ray and none of rays for a box. Rays go each by itself ([`Walks`]) or in
//! [`Packets`].
//!
//! Which boxes a ray enters does not depend on other rays, and not on the instruction set: the
//! distances of boxes have the same bits on each. The order does.

mod packets;
mod walks;

use glam::Vec3;

pub(crate) use self::packets::Packets;
pub(crate) use self::walks::{TOGETHER, Walks};
use super::layout::{BOX_ERROR, Child, Node, WIDTH, stack_size};
use super::ray::TAME_COORDINATE;
use super::{builder, careful};
use crate::isa::Isa;
use crate::math::Bounds;
use crate::structure::shared::pages::Array;

/// A hierarchy over boxes, with what is in each.
#[derive(Debug)]
pub(crate) struct Boxes<T> {
    nodes: Array<Node>,
    /// What is in the boxes, in the order of leaves.
    contents: Array<T>,
    /// Entries that a ray's stack needs.
    stack: usize,
    /// By how much rays are widened, in units of the largest coordinate of their origins.
    error: f32,
    /// Whether tame rays stay tame here.
    is_tame: bool,
    isa: Isa,
}

impl<T: Copy + Send + Sync> Boxes<T> {
    /// More boxes have no numbers.
    pub(crate) const MAX: usize = 1 << 28;

    /// Builds a hierarchy over `count` boxes, some of which may be `None`: these are never entered.
    /// `content` is what is in each of the others.
    ///
    /// `error` is by how much what is in a box may lie outside it, in units of the largest
    /// coordinate of a ray's origin.
    pub(crate) fn build(
        count: usize,
        bounds: impl Fn(u32) -> Option<Bounds> + Sync,
        content: impl Fn(u32) -> T,
        error: f32,
        isa: Isa,
    ) -> Self {
        let (mut nodes, depth) = builder::build_over(count, bounds, isa);
        let number = leaves(&mut nodes).count();
        let first = leaves(&mut nodes).next().map(|child| content(child.index() as u32));
        let mut contents = first.map_or_else(Array::default, |first| Array::filled(first, number));
        for (number, child) in (0..).zip(leaves(&mut nodes)) {
            contents[number as usize] = content(child.index() as u32);
            *child = Child::curved(number);
        }
        let stack = stack_size(depth);
        let mut boxes =
            Self { nodes, contents, stack, error: error + BOX_ERROR, is_tame: true, isa };
        let all = boxes.bounds();
        boxes.is_tame =
            all.is_empty() || all.min.abs().max(all.max.abs()).max_element() <= TAME_COORDINATE;
        boxes
    }

    /// The instruction set of queries.
    pub(crate) fn isa(&self) -> Isa {
        self.isa
    }

    /// What is in a box.
    #[inline]
    pub(crate) fn content(&self, leaf: u32) -> &T {
        &self.contents[leaf as usize]
    }

    /// Bytes held.
    pub(crate) fn memory(&self) -> usize {
        size_of_val(&*self.nodes) + size_of_val(&*self.contents)
    }

    /// The box about all boxes.
    pub(crate) fn bounds(&self) -> Bounds {
        self.parts(WIDTH).into_iter().fold(Bounds::EMPTY, Bounds::union)
    }

    /// Boxes about all boxes: at most `count`, or 8.
    pub(crate) fn parts(&self, count: usize) -> Vec<Bounds> {
        parts(&self.nodes, count)
    }

    /// Calls `visit` with each box that a ray may enter before its end, nearest first as far as the
    /// tree tells. `visit` returns the ray's end from then on, negative if it is done. For rays
    /// that are not tame; boxes are tested in f64.
    #[cold]
    pub(crate) fn visit(
        &self,
        (origin, direction): (Vec3, Vec3),
        mut t_max: f32,
        mut visit: impl FnMut(u32) -> f32,
    ) {
        let reach = f64::from(origin.abs().max_element());
        let errors = (f64::from(self.error), f64::from(self.error) * reach);
        let octant = (0..3).fold(0, |bits, i| bits | u32::from(direction[i] < 0.0) << i);
        let mut stack = vec![];
        if !self.nodes.is_empty() {
            stack.push((0.0, Child::node(0)));
        }
        while let Some((t, child)) = stack.pop() {
            if t > f64::from(t_max) {
                continue;
            }
            if child.is_leaf() {
                t_max = visit(child.index() as u32);
                continue;
            }
            let node = &self.nodes[child.index()];
            for word in node.order {
                let place = (word >> (4 * octant) & 7) as usize;
                let end = f64::from(t_max);
                let entry = careful::enter((node, None), place, (origin, direction), end, errors);
                if let Some(t) = entry.filter(|_| node.children[place] != Child::DONE) {
                    stack.push((t, node.children[place]));
                }
            }
        }
    }
}

/// The boxes of a new hierarchy, in the order of nodes.
fn leaves(nodes: &mut [Node]) -> impl Iterator<Item = &mut Child> {
    let children = nodes.iter_mut().flat_map(|node| &mut node.children);
    children.filter(|child| child.is_leaf() && **child != Child::DONE)
}

/// Boxes of nodes about everything that is below them, at most `count`; the largest are divided
/// first.
pub(super) fn parts(nodes: &[Node], count: usize) -> Vec<Bounds> {
    let of = |node: &Node| -> Vec<(Bounds, Child)> {
        let child = |place: usize| {
            let planes =
                |side: usize| Vec3::from_array([0, 2, 4].map(|k| node.planes[k + side][place]));
            (Bounds { min: planes(0), max: planes(1) }, node.children[place])
        };
        (0..WIDTH).map(child).filter(|(_, child)| *child != Child::DONE).collect()
    };
    let mut all = nodes.first().map(of).unwrap_or_default();
    loop {
        let inner = (0..all.len()).filter(|&i| !all[i].1.is_leaf());
        let area = |i: usize| all[i].0.area();
        let largest = inner.max_by(|&a, &b| area(a).total_cmp(&area(b)));
        let Some(largest) = largest.filter(|_| all.len() + WIDTH - 1 <= count) else { break };
        let (_, node) = all.swap_remove(largest);
        all.extend(of(&nodes[node.index()]));
    }
    all.into_iter().map(|(bounds, _)| bounds).collect()
}
