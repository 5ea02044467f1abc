//! A ray in flight.

use crate::rays::LANES;
use crate::rays::NO_HIT;
use crate::simd::{Quads, deal_rows};
use crate::structure::kdtree::leaf::Best;
use crate::structure::kdtree::ray::{Line, Prepared};

/// A ray in flight, in rows of four numbers. Some rows are loaded as a whole. Its stack follows in
/// memory.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Ray {
    /// See [`Prepared`], as the following. `near` and `far` are those at the root.
    pub(crate) inverse: [f32; 3],
    pub(crate) near: f32,
    pub(crate) early: [f32; 3],
    pub(crate) far: f32,
    pub(crate) late: [f32; 3],
    pub(crate) t: f32,
    pub(crate) origin: [f32; 3],
    pub(crate) way: u32,
    pub(crate) shear: [f32; 3],
    pub(crate) index: u32,
    pub(crate) u: f32,
    pub(crate) v: f32,
    pub(crate) primitive: u32,
    /// Number of entries on its stack.
    pub(crate) top: u32,
}

impl Ray {
    /// One of sixteen rays.
    #[inline(always)]
    pub(crate) fn new(rays: &Prepared, lane: usize) -> Self {
        let three = |rows: &[[f32; LANES]; 3]| [rows[0][lane], rows[1][lane], rows[2][lane]];
        Self {
            inverse: three(&rays.inverse),
            near: rays.near[lane],
            early: three(&rays.early),
            far: rays.far[lane],
            late: three(&rays.late),
            t: rays.t[lane],
            origin: three(&rays.origin),
            way: rays.way[lane],
            shear: three(&rays.shear),
            index: rays.index[lane],
            u: 0.0,
            v: 0.0,
            primitive: NO_HIT,
            top: 0,
        }
    }

    /// Sixteen rays, transposed by wide registers.
    ///
    /// # Safety
    /// The CPU has the instructions of `L`.
    #[inline(always)]
    pub(crate) unsafe fn deal<L: Quads>(rays: &Prepared, to: &mut [Self; LANES]) {
        let zero = [0.0f32; LANES];
        let none = [NO_HIT; LANES];
        let bits = |row: &[u32; LANES]| row.as_ptr().cast::<f32>();
        let three = |rows: &[[f32; LANES]; 3], last| {
            [rows[0].as_ptr(), rows[1].as_ptr(), rows[2].as_ptr(), last]
        };
        let rows = [
            three(&rays.inverse, rays.near.as_ptr()),
            three(&rays.early, rays.far.as_ptr()),
            three(&rays.late, rays.t.as_ptr()),
            three(&rays.origin, bits(&rays.way)),
            three(&rays.shear, bits(&rays.index)),
            [zero.as_ptr(), zero.as_ptr(), bits(&none), zero.as_ptr()],
        ];
        // SAFETY: the caller's; rows have sixteen numbers, and rays six times four.
        unsafe { deal_rows::<L>(&rows, to.as_mut_ptr().cast(), size_of::<Self>() / 4) }
    }

    #[inline(always)]
    pub(crate) fn axes(&self) -> [usize; 3] {
        [[1, 2, 0], [2, 0, 1], [0, 1, 2]][(self.way >> 3) as usize]
    }

    #[inline(always)]
    pub(crate) fn line(&self) -> Line {
        Line { origin: self.origin, shear: self.shear, axes: self.axes() }
    }

    #[inline(always)]
    pub(crate) fn is_hit(&self) -> bool {
        self.primitive != NO_HIT
    }

    #[inline(always)]
    pub(crate) fn best(&self) -> Best {
        Best { t: self.t, u: self.u, v: self.v, primitive: self.primitive }
    }

    #[inline(always)]
    pub(crate) fn set_best(&mut self, best: &Best) {
        (self.t, self.u, self.v, self.primitive) = (best.t, best.u, best.v, best.primitive);
    }
}
