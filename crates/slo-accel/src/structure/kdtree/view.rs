//! The rays of a packet while they are in a cell, as seen along them.
//!
//! A hit lies in one of the cells through which its ray is followed, and its triangle is in the
//! leaf of that cell. A triangle that is beside all rays for as long as they are in a cell can
//! therefore be left out there, wherever its corners are: rays that hit it do so in another cell.
//! Bounds of whole rays are much weaker if the rays cross, as those of a lens do.

#![allow(clippy::needless_range_loop)] // closures around intrinsics would become calls

use super::tree::KdTree;
use crate::math::rounding::UNIT_ROUNDOFF;
use crate::primitives::triangle::POSITION_ERROR;
use crate::primitives::triangle::turned::larger;
use crate::simd::Lanes;

/// 1 / length of directions that are too short: their slopes lose their digits.
const SHORT: f32 = f32::from_bits((127 + 100) << 23);

/// Rays as seen along a direction amid theirs, so that each ray covers little. Across that
/// direction a ray is at `start + t slope`, in the first two of the sheared axes.
pub(super) struct View<V> {
    /// The direction, as a shear ([`triangle`](crate::primitives::triangle)).
    pub(super) shear: [V; 2],
    start: [V; 2],
    slope: [V; 2],
    /// How far the points of hits may lie beside the rays.
    slack: f32,
}

impl<V: Lanes> View<V> {
    /// # Safety
    /// The CPU has the instructions of `V`.
    #[inline(always)]
    pub(super) unsafe fn new(
        tree: &KdTree,
        axes: [usize; 3],
        origin: [V; 3],
        shear: [V; 3],
        set: u32,
    ) -> Self {
        // SAFETY: the caller's.
        unsafe {
            let (zero, infinity) = (V::splat(0.0), V::splat(f32::INFINITY));
            let only = |x: V| infinity.replace(set, x);
            let negative = |x: V| infinity.replace(set, zero.sub(x));
            let [x, y, z] = origin;
            let [x_least, y_least, z_least, _] = V::leasts([only(x), only(y), only(z), zero]);
            let origin_least = [x_least, y_least, z_least];
            let [x_most, y_most, z_most, _] =
                V::leasts([negative(x), negative(y), negative(z), zero]);
            let origin_most = [-x_most, -y_most, -z_most];
            let shears =
                V::leasts([only(shear[0]), negative(shear[0]), only(shear[1]), negative(shear[1])]);
            let middle = [0.5 * (shears[0] - shears[1]), 0.5 * (shears[2] - shears[3])];
            let (mut reach, mut coordinate) = (0.0, 0.0);
            for k in 0..3 {
                let (min, max) = (tree.bounds.min[axes[k]], tree.bounds.max[axes[k]]);
                let (least, most) = (origin_least[k], origin_most[k]);
                reach = larger(larger(max - least, most - min), reach);
                let farthest = larger(larger(max, most), larger(-min, -least));
                coordinate = larger(farthest, coordinate);
            }
            let middle = [V::splat(middle[0]), V::splat(middle[1])];
            let along = V::splat(1.0).div(shear[2]);
            // Slopes of directions so short lose their digits.
            let are_short = V::splat(SHORT).lt(shear[2].abs()) & set != 0;
            let slack = 4.0 * POSITION_ERROR * reach + 16.0 * UNIT_ROUNDOFF * coordinate;
            Self {
                shear: middle,
                start: [middle[0].neg_mul_add(z, x), middle[1].neg_mul_add(z, y)],
                slope: [shear[0].sub(middle[0]).mul(along), shear[1].sub(middle[1]).mul(along)],
                slack: if are_short { f32::INFINITY } else { slack },
            }
        }
    }

    /// Between which positions some rays are while they are in a cell.
    ///
    /// # Safety
    /// The CPU has the instructions of `V`.
    #[inline(always)]
    pub(super) unsafe fn of(&self, lanes: u32, [near, far]: [V; 2]) -> Seen {
        // SAFETY: the caller's.
        unsafe {
            let (zero, infinity) = (V::splat(0.0), V::splat(f32::INFINITY));
            let mut ends = [infinity; 4];
            for k in 0..2 {
                let enters = self.slope[k].mul_add(near, self.start[k]);
                let leaves = self.slope[k].mul_add(far, self.start[k]);
                ends[k] = infinity.replace(lanes, enters.min(leaves));
                ends[2 + k] = infinity.replace(lanes, zero.sub(enters.max(leaves)));
            }
            let ends = V::leasts(ends);
            Seen {
                least: [ends[0] - self.slack, ends[1] - self.slack],
                most: [self.slack - ends[2], self.slack - ends[3]],
            }
        }
    }
}

/// Bounds of the rays' hits, across the direction of a [`View`].
pub(super) struct Seen {
    pub(super) least: [f32; 2],
    pub(super) most: [f32; 2],
}
