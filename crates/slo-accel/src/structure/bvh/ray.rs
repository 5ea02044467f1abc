//! Rays prepared for tests of boxes and triangles.

use glam::Vec3;

use super::layout::BOX_ERROR;
use crate::primitives::triangle::ShearedRay;
use crate::primitives::triangle::turned::{Turned, lanes_from, larger};
use crate::rays::{LANES, Rays};
use crate::simd::{Quads, deal_rows};
use crate::structure::shared::order::Numbers;

/// Scenes and rays are tame if their coordinates stay below this: no distance to a plane overflows.
pub(super) const TAME_COORDINATE: f32 = (1u64 << 60) as f32;

/// The largest component of a tame direction, at most.
const TAME_DIRECTION: f32 = (1u64 << 30) as f32;

/// Smaller components of a direction, relative to its largest, are replaced by this. Over the
/// length of a scene this moves a point by 2^-32 of its size, far less than the boxes are widened;
/// and the inverse stays finite.
const LEAST_COMPONENT: f32 = 1.0 / (1u64 << 32) as f32;

/// Sixteen prepared rays of a batch, neighbours or any, as a structure of arrays.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Prepared {
    /// Inverse of the direction, by axis.
    pub(super) inverse: [[f32; LANES]; 3],
    /// Its absolute value.
    pub(super) size: [[f32; LANES]; 3],
    /// What to subtract from `plane * inverse` so that the result is at most the distance to a
    /// plane where the ray enters.
    pub(super) near: [[f32; LANES]; 3],
    /// The same for planes where it leaves, the result being at least the distance.
    pub(super) far: [[f32; LANES]; 3],
    /// Origins by axis, turned so that the ray goes toward larger coordinates, and moved by the
    /// error of a test of a box: where the ray enters, and where it leaves.
    pub(super) entering: [[f32; LANES]; 3],
    pub(super) leaving: [[f32; LANES]; 3],
    /// Origin in sheared axes.
    pub(super) origin: [[f32; LANES]; 3],
    /// The shear of [`ShearedRay`].
    pub(super) shear: [[f32; LANES]; 3],
    /// End of the ray.
    pub(super) t_max: [f32; LANES],
    /// Which axis of space is z of the sheared ones; x and y follow it in cyclic order.
    pub(super) z_axis: [u32; LANES],
    /// Bit `axis` is set if the direction is negative along that axis.
    pub(super) octant: [u32; LANES],
    /// 1 if the fast kernels may trace the ray: nothing in it overflows on the way to a box.
    pub(super) is_tame: [u32; LANES],
    /// Its index in the batch.
    pub(super) index: [u32; LANES],
    /// Time of the ray, from 0 to 1, if what it may hit moves.
    pub(super) time: [f32; LANES],
    /// Whether the indices are consecutive.
    pub(super) are_neighbours: bool,
}

impl Prepared {
    pub(super) const EMPTY: Self = Self {
        inverse: [[0.0; LANES]; 3],
        size: [[0.0; LANES]; 3],
        near: [[0.0; LANES]; 3],
        far: [[0.0; LANES]; 3],
        entering: [[0.0; LANES]; 3],
        leaving: [[0.0; LANES]; 3],
        origin: [[0.0; LANES]; 3],
        shear: [[0.0; LANES]; 3],
        t_max: [0.0; LANES],
        z_axis: [0; LANES],
        octant: [0; LANES],
        is_tame: [0; LANES],
        index: [0; LANES],
        time: [0.0; LANES],
        are_neighbours: true,
    };

    /// Sets the times of the rays from those of the batch.
    #[inline(always)]
    pub(super) fn set_times(&mut self, times: &[f32]) {
        let last = times.len() - 1;
        for (time, &index) in self.time.iter_mut().zip(&self.index) {
            *time = times[(index as usize).min(last)];
        }
        for time in &mut self.time {
            // Boxes hold triangles from 0 to 1. NaN becomes 0.
            *time = if *time > 0.0 { *time } else { 0.0 };
            *time = if *time < 1.0 { *time } else { 1.0 };
        }
    }

    /// Prepares the sixteen rays from `first` on.
    #[inline(always)]
    pub(super) fn fill(&mut self, rays: &Rays, first: usize) {
        self.fill_widened(rays, &rays.t_max, first, BOX_ERROR);
    }

    /// As [`fill`](Self::fill), for rays that end at `t_max` and are widened by `error`, in units of
    /// the largest coordinate of their origins.
    #[inline(always)]
    pub(super) fn fill_widened(&mut self, rays: &Rays, t_max: &[f32], first: usize, error: f32) {
        for (lane, index) in self.index.iter_mut().enumerate() {
            *index = (first + lane) as u32;
        }
        self.are_neighbours = true;
        self.t_max.copy_from_slice(&t_max[first..first + LANES]);
        self.derive(lanes_from(&rays.origin, first), lanes_from(&rays.direction, first), error);
    }

    /// Prepares sixteen rays of a batch, given by index and value.
    #[inline(always)]
    pub(super) fn choose(
        &mut self,
        indices: &[u32; LANES],
        [ox, oy, oz, dx, dy, dz, t_max]: Numbers,
    ) {
        self.index = *indices;
        self.are_neighbours = false;
        self.t_max = *t_max;
        self.derive([*ox, *oy, *oz], [*dx, *dy, *dz], BOX_ERROR);
    }

    /// Inlined, so that loops over lanes are compiled for the caller's instruction set.
    #[inline(always)]
    fn derive(&mut self, origin: [[f32; LANES]; 3], direction: [[f32; LANES]; 3], error: f32) {
        for lane in 0..LANES {
            let [ox, oy, oz] = [origin[0][lane], origin[1][lane], origin[2][lane]];
            let [dx, dy, dz] = [direction[0][lane], direction[1][lane], direction[2][lane]];
            let turned = Turned::new([ox, oy, oz], [dx, dy, dz]);
            let largest = turned.largest;
            let reach = larger(larger(ox.abs(), oy.abs()), oz.abs());
            for axis in 0..3 {
                let (o, d) = ([ox, oy, oz][axis], [dx, dy, dz][axis]);
                let size = 1.0 / larger(d.abs(), largest * LEAST_COMPONENT);
                let forward = f32::from_bits(o.to_bits() ^ d.to_bits() & 1 << 31);
                let error = error * reach;
                self.entering[axis][lane] = forward + error;
                self.leaving[axis][lane] = forward - error;
                self.size[axis][lane] = size;
                self.inverse[axis][lane] = size.copysign(d);
                self.near[axis][lane] = (forward + error) * size;
                self.far[axis][lane] = (forward - error) * size;
                self.origin[axis][lane] = turned.origin[axis];
                self.shear[axis][lane] = turned.shear[axis];
            }
            self.z_axis[lane] = turned.z_axis;
            self.octant[lane] =
                dx.to_bits() >> 31 | dy.to_bits() >> 31 << 1 | dz.to_bits() >> 31 << 2;
            self.is_tame[lane] = u32::from(reach <= TAME_COORDINATE)
                & u32::from(largest >= 1.0 / TAME_DIRECTION)
                & u32::from(largest <= TAME_DIRECTION);
        }
    }
}

/// A ray in flight with all that tests of boxes and triangles need, in rows of four numbers. Some
/// rows are loaded as a whole.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Ray {
    /// See [`Prepared`], as the following.
    pub(super) inverse: [f32; 3],
    /// Distance of the best hit, or the end of the ray.
    pub(super) t: f32,
    pub(super) near: [f32; 3],
    /// Shift of the orders of children: four times the octant.
    pub(super) order_shift: u32,
    pub(super) far: [f32; 3],
    /// Its index in the batch.
    pub(super) index: u32,
    pub(super) origin: [f32; 3],
    pub(super) u: f32,
    pub(super) shear: [f32; 3],
    pub(super) v: f32,
    /// Which axes of space the sheared ones are.
    pub(super) axes: [u32; 3],
    /// Id of the best hit; 0 before the first, so that a hit exactly at the end of the ray does not
    /// count as equal with a lower id.
    pub(super) primitive: u32,
    /// Byte offsets in a node of the three planes that the ray enters through; it leaves through
    /// the planes 32 bytes after or before.
    pub(super) entries: [u32; 3],
    /// 1 if there is a hit, 0 if not.
    pub(super) is_hit: u32,
    /// Where the distance of the stack's next entry is stored.
    pub(super) top: *mut f32,
    /// See [`Prepared`].
    pub(super) time: f32,
}

impl Ray {
    /// One of sixteen rays, without a stack.
    #[inline(always)]
    pub(super) fn new(rays: &Prepared, lane: usize) -> Self {
        let octant = rays.octant[lane];
        let z_axis = rays.z_axis[lane] as usize;
        Self {
            inverse: [rays.inverse[0][lane], rays.inverse[1][lane], rays.inverse[2][lane]],
            t: rays.t_max[lane],
            near: [rays.near[0][lane], rays.near[1][lane], rays.near[2][lane]],
            order_shift: 4 * octant,
            far: [rays.far[0][lane], rays.far[1][lane], rays.far[2][lane]],
            index: rays.index[lane],
            origin: [rays.origin[0][lane], rays.origin[1][lane], rays.origin[2][lane]],
            u: 0.0,
            shear: [rays.shear[0][lane], rays.shear[1][lane], rays.shear[2][lane]],
            v: 0.0,
            axes: [[1, 2, 0], [2, 0, 1], [0, 1, 2]][z_axis],
            primitive: 0,
            entries: Self::entries(octant),
            is_hit: 0,
            top: std::ptr::null_mut(),
            time: rays.time[lane],
        }
    }

    /// Sixteen rays as [`new`](Self::new) makes them, but for `top`, and for `time` if nothing
    /// moves, transposed by wide registers.
    ///
    /// # Safety
    /// The CPU has the instructions of `L`.
    #[cfg_attr(not(target_arch = "x86_64"), allow(dead_code))]
    #[inline(always)]
    pub(super) unsafe fn deal<L: Quads, const MOVES: bool>(
        rays: &Prepared,
        to: &mut [Self; LANES],
    ) {
        let mut entries = [[0u32; LANES]; 3];
        let mut axes = [[0u32; LANES]; 3];
        let mut shifts = [0u32; LANES];
        for lane in 0..LANES {
            let (octant, z) = (rays.octant[lane], rays.z_axis[lane]);
            shifts[lane] = 4 * octant;
            let [x, y, z_entry] = Self::entries(octant);
            (entries[0][lane], entries[1][lane], entries[2][lane]) = (x, y, z_entry);
            axes[0][lane] = if z == 2 { 0 } else { z + 1 };
            axes[1][lane] = if z == 0 { 2 } else { z - 1 };
            axes[2][lane] = z;
        }
        let zero = [0u32; LANES];
        let bits = |row: &[u32; LANES]| row.as_ptr().cast::<f32>();
        let three = |rows: &[[f32; LANES]; 3], last| {
            [rows[0].as_ptr(), rows[1].as_ptr(), rows[2].as_ptr(), last]
        };
        let three_bits =
            |rows: &[[u32; LANES]; 3], last| [bits(&rows[0]), bits(&rows[1]), bits(&rows[2]), last];
        let rows = [
            three(&rays.inverse, rays.t_max.as_ptr()),
            three(&rays.near, bits(&shifts)),
            three(&rays.far, bits(&rays.index)),
            three(&rays.origin, bits(&zero)),
            three(&rays.shear, bits(&zero)),
            three_bits(&axes, bits(&zero)),
            three_bits(&entries, bits(&zero)),
        ];
        const { assert!(std::mem::offset_of!(Self, top) == 7 * 16) };
        // SAFETY: the caller's; rows have sixteen numbers, and rays seven times four.
        unsafe { deal_rows::<L>(&rows, to.as_mut_ptr().cast(), size_of::<Self>() / 4) }
        if MOVES {
            for (ray, &time) in to.iter_mut().zip(&rays.time) {
                ray.time = time;
            }
        }
    }

    /// See the field.
    #[inline(always)]
    pub(super) fn entries(octant: u32) -> [u32; 3] {
        [(octant & 1) << 5, 64 | (octant & 2) << 4, 128 | (octant & 4) << 3]
    }

    /// The ray for the portable test of triangles.
    pub(super) fn sheared(&self) -> ShearedRay {
        let axes = self.axes.map(|axis| axis as usize);
        let mut origin = Vec3::ZERO;
        for (place, axis) in axes.into_iter().enumerate() {
            origin[axis] = self.origin[place];
        }
        ShearedRay { origin, axes, shear: self.shear }
    }

    /// Keeps a hit that is nearer than the best, or as near and of lower id.
    #[inline(always)]
    pub(super) fn offer(&mut self, t: f32, u: f32, v: f32, primitive: u32) {
        if t < self.t || (t == self.t && primitive < self.primitive) {
            (self.t, self.u, self.v, self.primitive) = (t, u, v, primitive);
            self.is_hit = 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng, rngs::StdRng};

    use super::*;

    #[test]
    fn prepared_rays_are_sheared_like_the_tests_of_triangles_ask() {
        let mut rng = StdRng::seed_from_u64(1);
        let mut vector = || Vec3::from_array(std::array::from_fn(|_| rng.random_range(-9.0..9.0)));
        let mut rays = Rays::default();
        for i in 0..64 {
            let (o, mut d) = (vector(), vector());
            if i % 4 == 0 {
                d = d.round();
            }
            rays.push(o, if d == Vec3::ZERO { Vec3::X } else { d }, 1.0);
        }
        let mut prepared = Prepared::EMPTY;
        for i in 0..64 {
            prepared.fill(&rays, i / LANES * LANES);
            let ray = Ray::new(&prepared, i % LANES);
            assert_eq!(ray.index, i as u32);
            let expected = ShearedRay::new(rays.origin(i), rays.direction(i));
            assert_eq!(ray.axes, expected.axes.map(|axis| axis as u32));
            assert_eq!(ray.shear, expected.shear);
            assert_eq!(ray.origin, expected.axes.map(|axis| expected.origin[axis]));
            for axis in 0..3 {
                let negative = rays.direction[axis][i].is_sign_negative();
                assert_eq!(ray.order_shift >> (2 + axis) & 1 == 1, negative);
                assert_eq!(ray.entries[axis], 64 * axis as u32 + 32 * u32::from(negative));
                assert!(ray.far[axis] <= ray.near[axis] && ray.inverse[axis].is_finite());
            }
        }
    }
}
