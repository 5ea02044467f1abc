//! A ray made ready to walk through the tree.

use glam::Vec3;

use crate::accel::triangle::{POSITION_ERROR, ShearedRay};
use crate::math::Bounds;

/// What the walk needs of a ray.
///
/// A hit's t may differ from that of the point it stands for, and the point may lie beside the
/// ray, both by rounding. `slack` is how much later or earlier than computed a ray may cross a
/// plane for all that; a child is skipped only if the ray is clear of it by more.
#[derive(Clone, Copy, Debug)]
pub(super) struct WalkRay {
    pub(super) sheared: ShearedRay,
    pub(super) direction: Vec3,
    /// 1 / direction, never infinite.
    pub(super) inverse: Vec3,
    pub(super) slack: Vec3,
}

impl WalkRay {
    pub(super) fn new(origin: Vec3, direction: Vec3, bounds: &Bounds) -> Self {
        let reach = (bounds.min - origin).abs().max((bounds.max - origin).abs());
        let error = POSITION_ERROR * reach.max_element();
        let inverse = direction.map(|d| d.recip().abs().min(f32::MAX).copysign(d));
        let slack = (error * inverse.abs()).min(Vec3::MAX);
        Self { sheared: ShearedRay::new(origin, direction), direction, inverse, slack }
    }

    /// When the ray crosses a plane.
    #[inline(always)]
    pub(super) fn crossing(&self, axis: usize, position: f32) -> f32 {
        (position - self.sheared.origin[axis]) * self.inverse[axis]
    }

    /// The part of `0..=t_max` in which the ray may meet what is in the bounds.
    pub(super) fn span(&self, bounds: &Bounds, t_max: f32) -> Option<[f32; 2]> {
        let (mut near, mut far) = (0.0f32, t_max);
        for axis in 0..3 {
            let a = self.crossing(axis, bounds.min[axis]);
            let b = self.crossing(axis, bounds.max[axis]);
            near = near.max(a.min(b) - self.slack[axis]);
            far = far.min(a.max(b) + self.slack[axis]);
        }
        (near <= far).then_some([near, far])
    }
}
