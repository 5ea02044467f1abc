//! Rays made ready for boxes and triangles.

use glam::Vec3;

use super::layout::{BOX_ERROR, Child};
use crate::accel::triangle::ShearedRay;

/// Scenes whose coordinates, and rays whose origins, stay below this are tame: no distance to a
/// plane overflows.
pub(super) const TAME_COORDINATE: f32 = (1u64 << 60) as f32;

/// The largest component of a tame direction, at most.
const TAME_DIRECTION: f32 = (1u64 << 30) as f32;

/// Smaller components of a direction, relative to its largest one, are taken for this large. Over
/// the length of a scene this moves a point by 2^-32 of its size, far less than the boxes are
/// widened; and the inverse stays finite.
const LEAST_COMPONENT: f32 = 1.0 / (1u64 << 32) as f32;

/// A ray that is being traced, with all that tests of boxes and triangles ask for.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Ray {
    /// Inverse of the direction, by axis.
    pub(super) inverse: [f32; 3],
    /// What to subtract from `plane * inverse` so that the result is at most the distance to a
    /// plane where the ray enters.
    pub(super) near: [f32; 3],
    /// The same for planes where it leaves, the result being at least the distance.
    pub(super) far: [f32; 3],
    /// Distance of the best hit, or the end of the ray.
    pub(super) t: f32,
    /// Origin in sheared axes.
    pub(super) origin: [f32; 3],
    pub(super) shear: [f32; 3],
    /// Which axes of space the sheared ones are.
    pub(super) axes: [u32; 3],
    /// Bit `axis` is set where the direction is negative.
    pub(super) octant: u32,
    pub(super) u: f32,
    pub(super) v: f32,
    /// Id of the best hit; 0 before the first, so that nothing at the very end of the ray is taken
    /// for an equal of lower id.
    pub(super) primitive: u32,
    /// Whether there is a hit.
    pub(super) is_hit: bool,
    /// What it visits next.
    pub(super) current: Child,
    /// How many entries its stack has.
    pub(super) top: u32,
    /// Its place in the batch.
    pub(super) index: u32,
}

impl Ray {
    pub(super) fn new(origin: Vec3, direction: Vec3, t_max: f32) -> Self {
        let sheared = ShearedRay::new(origin, direction);
        let largest = direction.abs().max_element();
        let least = Vec3::splat(largest * LEAST_COMPONENT);
        let inverse = direction.abs().max(least).copysign(direction).recip();
        let error = BOX_ERROR * origin.abs().max_element() * inverse.abs();
        Self {
            inverse: inverse.to_array(),
            near: (origin * inverse + error).to_array(),
            far: (origin * inverse - error).to_array(),
            t: t_max,
            origin: sheared.axes.map(|axis| origin[axis]),
            shear: sheared.shear,
            axes: sheared.axes.map(|axis| axis as u32),
            octant: direction.is_negative_bitmask(),
            u: 0.0,
            v: 0.0,
            primitive: 0,
            is_hit: false,
            current: Child::node(0),
            top: 0,
            index: 0,
        }
    }

    /// Keeps a hit that is nearer than the best, or as near and of lower id.
    #[inline(always)]
    pub(super) fn offer(&mut self, t: f32, u: f32, v: f32, primitive: u32) {
        if t < self.t || (t == self.t && primitive < self.primitive) {
            (self.t, self.u, self.v, self.primitive) = (t, u, v, primitive);
            self.is_hit = true;
        }
    }

    /// Byte offsets of the three planes where the ray enters, in a node; it leaves through those
    /// 32 bytes on or back.
    #[inline(always)]
    pub(super) fn entries(&self) -> [usize; 3] {
        let octant = self.octant as usize;
        [(octant & 1) << 5, 64 | (octant & 2) << 4, 128 | (octant & 4) << 3]
    }
}

/// Whether the fast kernels may trace a ray: nothing in it overflows on the way to a box.
pub(super) fn is_tame(origin: Vec3, direction: Vec3) -> bool {
    let largest = direction.abs().max_element();
    origin.abs().max_element() <= TAME_COORDINATE
        && (1.0 / TAME_DIRECTION..=TAME_DIRECTION).contains(&largest)
}
