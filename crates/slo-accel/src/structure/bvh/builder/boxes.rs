//! Boxes of the builder: eight numbers, so that a union is one minimum.

use glam::{Vec3, Vec4};

use crate::math::Bounds;

/// A box, its upper corner negated. The fourth lanes mean nothing.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct Box8 {
    low: Vec4,
    high: Vec4,
}

impl Box8 {
    pub(super) const EMPTY: Self = Self { low: Vec4::INFINITY, high: Vec4::INFINITY };

    #[inline(always)]
    pub(super) fn half_area(&self) -> f32 {
        half_area(self.low, self.high)
    }

    /// Lengths of the sides.
    #[inline(always)]
    pub(super) fn size(&self) -> Vec4 {
        -self.high - self.low
    }

    #[inline(always)]
    pub(super) fn min(&self) -> Vec4 {
        self.low
    }

    #[inline(always)]
    pub(super) fn max(&self) -> Vec4 {
        -self.high
    }

    pub(super) fn bounds(&self) -> Bounds {
        Bounds { min: self.low.truncate(), max: -self.high.truncate() }
    }

    /// The box of one point.
    pub(super) fn point(p: Vec3) -> Self {
        let p = p.extend(0.0);
        Self { low: p, high: -p }
    }

    /// The smallest box about both.
    #[inline(always)]
    pub(super) fn union(&self, other: &Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.min(other.high) }
    }

    /// The points that lie in both boxes.
    #[inline(always)]
    pub(super) fn intersection(&self, other: &Self) -> Self {
        Self { low: self.low.max(other.low), high: self.high.max(other.high) }
    }

    /// The parts on each side of a plane through the box.
    #[inline(always)]
    pub(super) fn split<const AXIS: usize>(&self, at: f32) -> [Self; 2] {
        let (mut below, mut above) = (*self, *self);
        below.high[AXIS] = -at;
        above.low[AXIS] = at;
        [below, above]
    }

    /// This box with its corners clamped to another box.
    #[inline(always)]
    pub(super) fn clamped(&self, to: &Self) -> Self {
        let inside = |a: Vec4, low: Vec4, high: Vec4| a.max(low).min(-high);
        Self { low: inside(self.low, to.low, to.high), high: inside(self.high, to.high, to.low) }
    }
}

/// From both corners, the upper one negated.
#[inline(always)]
fn half_area(low: Vec4, high: Vec4) -> f32 {
    // Both factors of each product are negative.
    let d = low + high;
    d.x * (d.y + d.z) + d.y * d.z
}

/// The box of a primitive, with the halves of its id in the fourth lanes: exact in f32.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub(super) struct Reference(Box8);

impl Reference {
    pub(super) const NONE: Self = Self(Box8::EMPTY);

    pub(super) fn new(bounds: Bounds, id: u32) -> Self {
        Self(Box8 {
            low: bounds.min.extend((id >> 16) as f32),
            high: (-bounds.max).extend((id & 0xffff) as f32),
        })
    }

    #[inline(always)]
    pub(super) fn id(&self) -> u32 {
        (self.0.low.w as u32) << 16 | self.0.high.w as u32
    }

    /// Whether it is [`NONE`](Self::NONE).
    pub(super) fn is_none(&self) -> bool {
        self.0.low.w == f32::INFINITY
    }

    #[inline(always)]
    pub(super) fn bounds(&self) -> &Box8 {
        &self.0
    }

    #[inline(always)]
    pub(super) fn bounds_mut(&mut self) -> &mut Box8 {
        &mut self.0
    }

    /// Twice the middle of the box.
    #[inline(always)]
    pub(super) fn center(&self) -> Vec3 {
        center(self.0.low, self.0.high).truncate()
    }
}

/// Boxes about references and about their [centres](Reference::center).
pub(super) fn extent(references: &[Reference]) -> [Box8; 2] {
    references.iter().fold([Box8::EMPTY; 2], |[all, centers], r| {
        [all.union(r.bounds()), centers.union(&Box8::point(r.center()))]
    })
}

/// Twice the centre; infinite if it is too large.
#[inline(always)]
fn center(low: Vec4, high: Vec4) -> Vec4 {
    low - high
}

/// A box in registers.
///
/// # Safety
/// Its functions are inlined into kernels that are compiled for an instruction set, which the CPU
/// must have.
pub(super) trait Wide: Copy {
    unsafe fn load(from: &Box8) -> Self;
    unsafe fn store(self, to: &mut Box8);
    /// The smallest box about both; `other` in lanes where `self` is NaN.
    unsafe fn union(self, other: Self) -> Self;
    /// The box of one point.
    unsafe fn point(p: Vec4) -> Self;
    /// NaN in all lanes if `set`, unchanged otherwise.
    unsafe fn or_nan(self, set: bool) -> Self;
    /// Lower corner and negated upper corner.
    unsafe fn corners(self) -> [Vec4; 2];

    #[inline(always)]
    unsafe fn half_area(self) -> f32 {
        // SAFETY: the caller's.
        let [low, high] = unsafe { self.corners() };
        half_area(low, high)
    }

    #[inline(always)]
    unsafe fn center(self) -> Vec4 {
        // SAFETY: the caller's.
        let [low, high] = unsafe { self.corners() };
        center(low, high)
    }
}

/// Plain Rust.
#[derive(Clone, Copy)]
pub(super) struct Portable(Vec4, Vec4);

impl Wide for Portable {
    #[inline(always)]
    unsafe fn load(from: &Box8) -> Self {
        Self(from.low, from.high)
    }

    #[inline(always)]
    unsafe fn store(self, to: &mut Box8) {
        *to = Box8 { low: self.0, high: self.1 };
    }

    #[inline(always)]
    unsafe fn union(self, other: Self) -> Self {
        Self(smaller(self.0, other.0), smaller(self.1, other.1))
    }

    #[inline(always)]
    unsafe fn point(p: Vec4) -> Self {
        Self(p, -p)
    }

    #[inline(always)]
    unsafe fn or_nan(self, set: bool) -> Self {
        let mask = glam::BVec4A::splat(set);
        Self(Vec4::select(mask, Vec4::NAN, self.0), Vec4::select(mask, Vec4::NAN, self.1))
    }

    #[inline(always)]
    unsafe fn corners(self) -> [Vec4; 2] {
        [self.0, self.1]
    }
}

/// `b` in lanes where `a` is NaN or both are the same number.
#[inline(always)]
fn smaller(a: Vec4, b: Vec4) -> Vec4 {
    Vec4::select(a.cmplt(b), a, b)
}

#[cfg(target_arch = "x86_64")]
pub(super) mod x86 {
    //! Boxes in one register of AVX.

    use std::arch::x86_64::*;

    use glam::Vec4;

    use super::{Box8, Wide};

    impl Wide for __m256 {
        #[inline(always)]
        unsafe fn load(from: &Box8) -> Self {
            // SAFETY: a box is 32 bytes, aligned to as many.
            unsafe { _mm256_load_ps(std::ptr::from_ref(from).cast()) }
        }

        #[inline(always)]
        unsafe fn store(self, to: &mut Box8) {
            // SAFETY: as above.
            unsafe { _mm256_store_ps(std::ptr::from_mut(to).cast(), self) }
        }

        #[inline(always)]
        unsafe fn union(self, other: Self) -> Self {
            // SAFETY: the caller's.
            unsafe { _mm256_min_ps(self, other) }
        }

        #[inline(always)]
        unsafe fn point(p: Vec4) -> Self {
            // SAFETY: the caller's.
            unsafe { _mm256_set_m128((-p).into(), p.into()) }
        }

        #[inline(always)]
        unsafe fn or_nan(self, set: bool) -> Self {
            // SAFETY: the caller's.
            unsafe {
                let mask = _mm256_set1_epi32(-i32::from(set));
                _mm256_or_ps(self, _mm256_castsi256_ps(mask))
            }
        }

        #[inline(always)]
        unsafe fn corners(self) -> [Vec4; 2] {
            // SAFETY: the caller's.
            unsafe {
                [_mm256_castps256_ps128(self).into(), _mm256_extractf128_ps::<1>(self).into()]
            }
        }
    }
}
