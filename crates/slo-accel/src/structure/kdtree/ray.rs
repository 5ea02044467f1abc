//! Rays prepared for the tree, sixteen at a time.

use crate::math::Bounds;
use crate::math::rounding::UNIT_ROUNDOFF;
use crate::primitives::triangle::turned::{Turned, lanes_from, larger, smaller};
use crate::primitives::triangle::{POSITION_ERROR, ShearedRay};
use crate::rays::{LANES, Rays};
use crate::structure::shared::order::Sixteen;

/// Components of a direction are raised to at least this part of the largest: the ray drifts by
/// less than the [`POSITION_ERROR`].
const SMALLEST_SLOPE: f32 = 1.0 / (1u32 << 30) as f32;

/// Rays as structures of arrays.
///
/// By rounding, a hit's t may be off, and its point may lie beside the ray. The t at which a ray
/// crosses a plane is therefore a span, and a child is skipped only if the ray is clear of it.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Prepared {
    /// 1 / direction, by axis, never infinite; negative if the upper child is the nearer.
    pub(super) inverse: [[f32; LANES]; 3],
    /// `position * inverse` less this is the earliest time of crossing.
    pub(super) early: [[f32; LANES]; 3],
    /// `position * inverse` less this is the latest time of crossing.
    pub(super) late: [[f32; LANES]; 3],
    /// Origin in sheared axes.
    pub(super) origin: [[f32; LANES]; 3],
    /// See [`ShearedRay`].
    pub(super) shear: [[f32; LANES]; 3],
    /// The span of the ray inside the tree's box; near > far if it misses.
    pub(super) near: [f32; LANES],
    pub(super) far: [f32; LANES],
    /// The largest t that still counts.
    pub(super) t: [f32; LANES],
    /// Bit `axis` is set if the inverse is negative. The bits above are the axis of space that is z
    /// of the sheared ones; x and y follow it in cyclic order.
    pub(super) way: [u32; LANES],
    /// Indices in the batch.
    pub(super) index: [u32; LANES],
    /// Origin along the axes of space.
    #[cfg_attr(not(target_arch = "x86_64"), allow(dead_code))]
    pub(super) start: [[f32; LANES]; 3],
    /// Whether the indices are consecutive.
    #[cfg_attr(not(target_arch = "x86_64"), allow(dead_code))]
    pub(super) are_neighbours: bool,
}

impl Prepared {
    pub(super) const EMPTY: Self = Self {
        inverse: [[0.0; LANES]; 3],
        early: [[0.0; LANES]; 3],
        late: [[0.0; LANES]; 3],
        origin: [[0.0; LANES]; 3],
        shear: [[0.0; LANES]; 3],
        near: [f32::INFINITY; LANES],
        far: [f32::NEG_INFINITY; LANES],
        t: [0.0; LANES],
        way: [0; LANES],
        index: [0; LANES],
        start: [[0.0; LANES]; 3],
        are_neighbours: true,
    };

    /// Prepares sixteen rays; those after the first `count` miss the tree.
    ///
    /// Inlined, so that loops over lanes are compiled for the caller's instruction set.
    ///
    /// # Safety
    /// The CPU has the instruction set of `C`; there are such rays.
    #[inline(always)]
    pub(super) fn take(&mut self, rays: &Rays, sixteen: Sixteen, count: usize, bounds: &Bounds) {
        self.are_neighbours = matches!(sixteen, Sixteen::Neighbours(_));
        match sixteen {
            Sixteen::Neighbours(first) => {
                let origin = lanes_from(&rays.origin, first);
                let direction = lanes_from(&rays.direction, first);
                let mut t_max = [0.0f32; LANES];
                t_max.copy_from_slice(&rays.t_max[first..first + LANES]);
                for lane in 0..LANES {
                    self.index[lane] = (first + lane) as u32;
                }
                self.derive(origin, direction, t_max, bounds);
            }
            Sixteen::Chosen(indices, [ox, oy, oz, dx, dy, dz, t_max]) => {
                self.index = *indices;
                self.derive([*ox, *oy, *oz], [*dx, *dy, *dz], *t_max, bounds);
            }
        }
        self.leave_out(count);
    }

    /// Makes the rays from `count` on miss the tree.
    #[inline(always)]
    fn leave_out(&mut self, count: usize) {
        for lane in count.min(LANES)..LANES {
            (self.near[lane], self.far[lane]) = (f32::INFINITY, f32::NEG_INFINITY);
        }
    }

    #[inline(always)]
    fn derive(
        &mut self,
        origin: [[f32; LANES]; 3],
        direction: [[f32; LANES]; 3],
        t_max: [f32; LANES],
        bounds: &Bounds,
    ) {
        self.start = origin;
        let (min, max) = (bounds.min.to_array(), bounds.max.to_array());
        for lane in 0..LANES {
            let [ox, oy, oz] = [origin[0][lane], origin[1][lane], origin[2][lane]];
            let [dx, dy, dz] = [direction[0][lane], direction[1][lane], direction[2][lane]];
            let turned = Turned::new([ox, oy, oz], [dx, dy, dz]);
            let mut reach = 0.0f32;
            for axis in 0..3 {
                let o = [ox, oy, oz][axis];
                reach = larger((min[axis] - o).abs(), larger((max[axis] - o).abs(), reach));
            }
            let least = SMALLEST_SLOPE * turned.largest;
            let t = f32::from_bits(t_max[lane].to_bits().wrapping_sub(1));
            let (mut near, mut far) = (0.0f32, t);
            let mut octant = 0;
            for axis in 0..3 {
                let (o, d) = ([ox, oy, oz][axis], [dx, dy, dz][axis]);
                let size = 1.0 / larger(d.abs(), least);
                let inverse = size.copysign(d);
                // Rounding of products with positions and of their differences from `start`.
                let coordinate = o.abs() + larger(min[axis].abs(), max[axis].abs());
                let rounding = 4.0 * UNIT_ROUNDOFF * coordinate;
                let slack = (POSITION_ERROR * reach + rounding) * size;
                let start = o * inverse;
                let (early, late) = (start + slack, start - slack);
                let falls = d.is_sign_negative();
                let entry = if falls { max[axis] } else { min[axis] };
                let exit = if falls { min[axis] } else { max[axis] };
                near = larger(entry * inverse - early, near);
                far = smaller(exit * inverse - late, far);
                octant |= u32::from(falls) << axis;
                self.inverse[axis][lane] = inverse;
                self.early[axis][lane] = early;
                self.late[axis][lane] = late;
                self.origin[axis][lane] = turned.origin[axis];
                self.shear[axis][lane] = turned.shear[axis];
            }
            self.near[lane] = near;
            self.far[lane] = far;
            self.t[lane] = t;
            self.way[lane] = octant | turned.z_axis << 3;
        }
    }

    /// The set of rays that enter the tree's box.
    #[inline(always)]
    pub(super) fn entering(&self) -> u32 {
        let mut set = 0;
        for lane in 0..LANES {
            set |= u32::from(self.near[lane] <= self.far[lane]) << lane;
        }
        set
    }

    /// One of the rays.
    #[inline(always)]
    pub(super) fn line(&self, lane: usize) -> Line {
        Line {
            origin: [self.origin[0][lane], self.origin[1][lane], self.origin[2][lane]],
            shear: [self.shear[0][lane], self.shear[1][lane], self.shear[2][lane]],
            axes: self.axes(lane),
        }
    }

    /// Which axes of space the sheared ones of a ray are.
    #[inline(always)]
    pub(super) fn axes(&self, lane: usize) -> [usize; 3] {
        [[1, 2, 0], [2, 0, 1], [0, 1, 2]][(self.way[lane] >> 3) as usize]
    }
}

/// A ray for the test of triangles, in sheared axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub(super) origin: [f32; 3],
    pub(super) shear: [f32; 3],
    /// Which axes of space the sheared ones are.
    pub(super) axes: [usize; 3],
}

impl Line {
    /// The ray for the portable test of triangles.
    #[inline(always)]
    pub(super) fn sheared(&self) -> ShearedRay {
        let mut origin = glam::Vec3::ZERO;
        for (place, axis) in self.axes.into_iter().enumerate() {
            origin[axis] = self.origin[place];
        }
        ShearedRay { origin, axes: self.axes, shear: self.shear }
    }
}
