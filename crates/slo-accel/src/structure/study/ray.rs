//! Rays against planes, in f64, so that no hit is missed.
//!
//! A hit's t is rounded, and its point may lie beside the ray by [`POSITION_ERROR`]. The time at
//! which a ray crosses a plane is therefore a span: on one side of the plane the ray may find hits
//! until its late end, on the other side from its early end. All structures of this room ask only
//! that, and so find the same hits as if they had tested everything.

use glam::Vec3;

use crate::math::Bounds;
use crate::primitives::triangle::POSITION_ERROR;

/// A ray: the points `origin + t direction` with `0 < t < t_max`. The direction may have any length
/// but 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Origin; finite.
    pub origin: Vec3,
    /// Direction; finite, not 0.
    pub direction: Vec3,
    /// End, in lengths of the direction; not NaN.
    pub t_max: f32,
}

impl Ray {
    /// Whether the ray may hit anything within a box.
    pub fn enters(&self, bounds: &Bounds) -> bool {
        let cell = Cell::of(bounds);
        let [near, far] = Line::new(self, &cell).span(&cell, self.t_max);
        near <= far
    }
}

/// A ray prepared for a structure.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    origin: [f64; 3],
    direction: [f64; 3],
    /// How far hits may lie beside the ray.
    error: f64,
    /// The time that the ray takes for that, by axis; infinite along axes that it does not follow.
    slack: [f64; 3],
}

/// When a ray crosses a plane: not before `early`, and not after `late`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing {
    pub(super) early: f64,
    pub(super) late: f64,
}

impl Line {
    /// Prepares a ray for a structure inside a box.
    pub(super) fn new(ray: &Ray, bounds: &Cell) -> Self {
        let origin = ray.origin.to_array().map(f64::from);
        let direction = ray.direction.to_array().map(f64::from);
        let mut reach = 0.0f64;
        for (axis, from) in origin.iter().enumerate() {
            reach = reach.max((bounds.min[axis] - from).abs());
            reach = reach.max((bounds.max[axis] - from).abs());
        }
        let error = f64::from(POSITION_ERROR) * reach;
        // Times below the smallest f32 are rounded to it.
        let slack = direction.map(|d| error / d.abs() + f64::from(f32::from_bits(4)));
        Self { origin, direction, error, slack }
    }

    /// Whether the ray goes toward smaller coordinates of an axis.
    #[inline]
    pub(super) fn falls(&self, axis: usize) -> bool {
        self.direction[axis] < 0.0
    }

    /// When the ray crosses the plane at a coordinate of an axis. A ray along the plane counts as
    /// one that rises: it stays before the plane for ever, or has always been behind it, or is on
    /// both sides if it is too close.
    #[inline]
    pub(super) fn crossing(&self, axis: usize, plane: f64) -> Crossing {
        let distance = plane - self.origin[axis];
        if self.direction[axis] == 0.0 {
            let early = if distance > self.error { f64::INFINITY } else { f64::NEG_INFINITY };
            let late = if distance < -self.error { f64::NEG_INFINITY } else { f64::INFINITY };
            return Crossing { early, late };
        }
        let t = distance / self.direction[axis];
        Crossing { early: t - self.slack[axis], late: t + self.slack[axis] }
    }

    /// From when to when the ray may find hits in a box: `near > far` if it cannot.
    #[inline]
    pub(super) fn span(&self, cell: &Cell, t_max: f32) -> [f64; 2] {
        let (mut near, mut far) = (0.0f64, f64::from(t_max));
        for axis in 0..3 {
            let (entry, exit) = if self.falls(axis) {
                (cell.max[axis], cell.min[axis])
            } else {
                (cell.min[axis], cell.max[axis])
            };
            near = near.max(self.crossing(axis, entry).early);
            far = far.min(self.crossing(axis, exit).late);
        }
        [near, far]
    }

    /// Coordinate of an axis at a time.
    #[inline]
    pub(super) fn at(&self, axis: usize, t: f64) -> f64 {
        self.origin[axis] + t * self.direction[axis]
    }
}

/// A box in f64.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    pub(super) min: [f64; 3],
    pub(super) max: [f64; 3],
}

impl Cell {
    /// The box of no object, which no ray meets.
    pub(super) const NOTHING: Self = Self { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };

    pub(super) fn of(bounds: &Bounds) -> Self {
        Self {
            min: bounds.min.to_array().map(f64::from),
            max: bounds.max.to_array().map(f64::from),
        }
    }

    /// The smallest box about both.
    pub(super) fn union(&self, other: &Self) -> Self {
        Self {
            min: std::array::from_fn(|axis| self.min[axis].min(other.min[axis])),
            max: std::array::from_fn(|axis| self.max[axis].max(other.max[axis])),
        }
    }

    /// Lengths of the sides.
    pub(super) fn size(&self) -> [f64; 3] {
        std::array::from_fn(|axis| self.max[axis] - self.min[axis])
    }

    /// Surface area.
    pub(super) fn area(&self) -> f64 {
        let [x, y, z] = self.size();
        2.0 * (x * y + y * z + z * x)
    }

    /// The box with this share of its size more on each side.
    pub(super) fn grown(&self, share: f64) -> Self {
        let by = self.size().map(|size| size * share);
        Self {
            min: std::array::from_fn(|axis| self.min[axis] - by[axis]),
            max: std::array::from_fn(|axis| self.max[axis] + by[axis]),
        }
    }
}

/// The objects that have a box, and the smallest box about them all.
pub(super) fn solid(objects: &[Bounds]) -> (Vec<u32>, Cell) {
    let has_box =
        |bounds: &Bounds| !bounds.is_empty() && bounds.min.is_finite() && bounds.max.is_finite();
    let ids = (0u32..).zip(objects).filter(|(_, bounds)| has_box(bounds)).map(|(id, _)| id);
    let ids: Vec<u32> = ids.collect();
    let all = ids.iter().map(|&id| Cell::of(&objects[id as usize]));
    let cell = all.fold(Cell::NOTHING, |all, one| all.union(&one));
    (ids, cell)
}
