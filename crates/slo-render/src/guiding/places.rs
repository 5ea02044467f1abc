//! A binary tree over the places of a scene.

use glam::Vec3;
use slo_accel::math::Bounds;

/// Steps along each axis of the box that holds all places.
const STEPS: f32 = (1 << 20) as f32;

/// Places as whole numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Grid {
    pub(super) least: Vec3,
    /// Steps per length.
    pub(super) scale: Vec3,
}

impl Grid {
    pub(super) fn new(bounds: Bounds) -> Self {
        let size = (bounds.max - bounds.min).max(Vec3::splat(f32::MIN_POSITIVE * STEPS));
        Self { least: bounds.min, scale: (Vec3::splat(STEPS) / size).min(Vec3::splat(f32::MAX)) }
    }

    /// Returns the step of a place along each axis. Places outside of the box count as places on its
    /// border.
    #[inline(always)]
    pub(super) fn steps(&self, place: Vec3) -> [u32; 3] {
        let steps = (place - self.least) * self.scale;
        steps.to_array().map(|step| step.clamp(0.0, STEPS - 1.0) as u32)
    }
}

/// A node of the tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Node {
    /// The first step that belongs to the second half.
    pub(super) split: u32,
    /// The axis in the upper two bits, and the number of the first half; the second follows. Of a leaf:
    /// [`LEAF`] and the number of the leaf.
    pub(super) next: u32,
}

/// The axis of a node that is not divided.
const LEAF: u32 = 3;
/// Bits of a number in [`Node::next`].
const NUMBER: u32 = 30;

impl Node {
    /// The leaf with a number.
    pub(super) fn leaf(number: u32) -> Self {
        Self { split: 0, next: LEAF << NUMBER | number }
    }

    /// A node that is divided along an axis, before step `split`.
    pub(super) fn divided(axis: usize, split: u32, first: u32) -> Self {
        Self { split, next: (axis as u32) << NUMBER | first }
    }

    /// The axis; 3 for a leaf.
    #[inline(always)]
    pub(super) fn axis(self) -> usize {
        (self.next >> NUMBER) as usize
    }

    /// The number of the first half, or of the leaf.
    #[inline(always)]
    pub(super) fn number(self) -> u32 {
        self.next & ((1 << NUMBER) - 1)
    }
}

/// Returns the number of the leaf that a place is in.
#[inline(always)]
pub(super) fn leaf_of(nodes: &[Node], steps: [u32; 3]) -> u32 {
    let mut at = 0;
    while let Some(node) = nodes.get(at) {
        let Some(step) = steps.get(node.axis()) else { return node.number() };
        at = node.number() as usize + usize::from(*step >= node.split);
    }
    0
}
