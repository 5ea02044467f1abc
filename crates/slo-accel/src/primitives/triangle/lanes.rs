//! The test of [`triangle`](super) on many lanes at once: the same operations in the same order.
//!
//! Lanes are triangles that one ray meets, or rays that meet one triangle.

use super::{MIN_DETERMINANT, SURE_OF_SIGN, ShearedRay, Triangle, lies_ahead};
use crate::simd::Lanes;

/// Results of the test so far, by lane.
#[derive(Clone, Copy)]
pub(crate) struct Tested<L> {
    area_b: L,
    area_c: L,
    determinant: L,
    /// Distances, in lanes with hits.
    pub(crate) t: L,
    /// The lanes whose ray hits the triangle at `0 < t <= t_max`; in lanes of `doubtful` the sign
    /// of t is not certain.
    pub(crate) hits: u32,
    /// Hits that count only if [`lies_ahead`] confirms them.
    doubtful: u32,
}

impl<L: Lanes> Tested<L> {
    /// Tests the lanes of a set: corners (x, y, and z in sheared axes, see
    /// [`ShearedRay`]), origin in sheared axes, shear, and end of the rays.
    ///
    /// # Safety
    /// The CPU has the instructions of `L`.
    #[inline(always)]
    pub(crate) unsafe fn new(
        corners: [[L; 3]; 3],
        origin: [L; 3],
        shear: [L; 3],
        t_max: L,
        lanes: u32,
    ) -> Self {
        // SAFETY: the caller's.
        unsafe { Self::test::<false, true>(corners, origin, shear, t_max, lanes) }
    }

    /// As [`new`](Self::new), with a branch as soon as it is known that all lanes miss: for callers
    /// whose lanes do so together.
    ///
    /// # Safety
    /// The CPU has the instructions of `L`.
    #[inline(always)]
    pub(crate) unsafe fn with_branch(
        corners: [[L; 3]; 3],
        origin: [L; 3],
        shear: [L; 3],
        t_max: L,
        lanes: u32,
    ) -> Self {
        // SAFETY: the caller's.
        unsafe { Self::test::<true, true>(corners, origin, shear, t_max, lanes) }
    }

    /// As [`new`](Self::new), without a branch: for callers that make many tests before they look
    /// at the first.
    ///
    /// # Safety
    /// The CPU has the instructions of `L`.
    #[inline(always)]
    pub(crate) unsafe fn without_branch(
        corners: [[L; 3]; 3],
        origin: [L; 3],
        shear: [L; 3],
        t_max: L,
        lanes: u32,
    ) -> Self {
        // SAFETY: the caller's.
        unsafe { Self::test::<false, false>(corners, origin, shear, t_max, lanes) }
    }

    /// As [`without_branch`](Self::without_branch), of corners that are [`sheared`] already; of the
    /// shear only its last number is asked for.
    ///
    /// # Safety
    /// The CPU has the instructions of `L`.
    #[inline(always)]
    pub(crate) unsafe fn of_sheared(corners: [[L; 3]; 3], along: L, t_max: L, lanes: u32) -> Self {
        // SAFETY: the caller's.
        unsafe { Self::test_sheared::<false, false>(corners, along, t_max, lanes) }
    }

    /// # Safety
    /// The CPU has the instructions of `L`.
    #[inline(always)]
    unsafe fn test<const EARLY: bool, const BRANCH: bool>(
        corners: [[L; 3]; 3],
        origin: [L; 3],
        shear: [L; 3],
        t_max: L,
        lanes: u32,
    ) -> Self {
        // SAFETY: the caller's.
        unsafe {
            let a = sheared(corners[0], origin, shear);
            let b = sheared(corners[1], origin, shear);
            let c = sheared(corners[2], origin, shear);
            Self::test_sheared::<EARLY, BRANCH>([a, b, c], shear[2], t_max, lanes)
        }
    }

    /// # Safety
    /// The CPU has the instructions of `L`.
    #[inline(always)]
    unsafe fn test_sheared<const EARLY: bool, const BRANCH: bool>(
        [a, b, c]: [[L; 3]; 3],
        along: L,
        t_max: L,
        lanes: u32,
    ) -> Self {
        // SAFETY: the caller's.
        unsafe {
            let area_a = difference_of_products(c[0], b[1], c[1], b[0]);
            let area_b = difference_of_products(a[0], c[1], a[1], c[0]);
            let area_c = difference_of_products(b[0], a[1], b[1], a[0]);
            let determinant = area_a.add(area_b).add(area_c);
            let zero = L::splat(0.0);
            let least = area_a.min(area_b).min(area_c);
            let most = area_a.max(area_b).max(area_c);
            let inside = lanes & (zero.le(least) | most.le(zero));
            if EARLY && inside == 0 {
                return Self { area_b, area_c, determinant, t: zero, hits: 0, doubtful: 0 };
            }
            let z = area_c.mul_add(c[2], area_b.mul_add(b[2], area_a.mul(a[2])));
            let t = z.div(determinant).mul(along);
            let size = determinant.abs();
            let hits = inside & L::splat(MIN_DETERMINANT).le(size) & zero.lt(t) & t.le(t_max);
            let doubtful = if BRANCH && hits == 0 {
                0
            } else {
                let reach = a[2].abs().max(b[2].abs()).max(c[2].abs());
                hits & z.abs().le(size.mul(reach).mul(L::splat(SURE_OF_SIGN)))
            };
            Self { area_b, area_c, determinant, t, hits, doubtful }
        }
    }

    /// Drops the doubtful hits that do not count; `pair` returns a lane's ray and triangle.
    ///
    /// # Safety
    /// The CPU has the instructions of `L`.
    #[inline(always)]
    pub(crate) unsafe fn settle(mut self, pair: impl Fn(usize) -> (ShearedRay, Triangle)) -> Self {
        while self.doubtful != 0 {
            // SAFETY: the caller's.
            let negative = unsafe { self.determinant.lt(L::splat(0.0)) };
            let lane = self.doubtful.trailing_zeros() as usize;
            let (ray, triangle) = pair(lane);
            if !lies_ahead(&ray, &triangle, negative >> lane & 1 == 1) {
                self.hits &= !(1 << lane);
            }
            self.doubtful &= self.doubtful - 1;
        }
        self
    }

    /// Weights of the second and third corner, in lanes with hits.
    ///
    /// # Safety
    /// The CPU has the instructions of `L`.
    #[inline(always)]
    pub(crate) unsafe fn weights(&self) -> [L; 2] {
        // SAFETY: the caller's.
        unsafe { [self.area_b.div(self.determinant), self.area_c.div(self.determinant)] }
    }

    /// Weights of the second and third corner before they are divided by the last.
    #[inline(always)]
    pub(crate) fn parts(&self) -> [L; 3] {
        [self.area_b, self.area_c, self.determinant]
    }
}

/// Corners in sheared coordinates.
///
/// # Safety
/// The CPU has the instructions of `L`.
#[inline(always)]
pub(crate) unsafe fn sheared<L: Lanes>(corner: [L; 3], origin: [L; 3], shear: [L; 3]) -> [L; 3] {
    // SAFETY: the caller's.
    unsafe {
        let z = corner[2].sub(origin[2]);
        let x = shear[0].neg_mul_add(z, corner[0].sub(origin[0]));
        let y = shear[1].neg_mul_add(z, corner[1].sub(origin[1]));
        [x, y, z]
    }
}

/// # Safety
/// The CPU has the instructions of `L`.
#[inline(always)]
unsafe fn difference_of_products<L: Lanes>(a: L, b: L, c: L, d: L) -> L {
    // SAFETY: the caller's.
    unsafe {
        let cd = c.mul(d);
        let error = c.neg_mul_add(d, cd);
        a.mul_sub(b, cd).add(error)
    }
}
