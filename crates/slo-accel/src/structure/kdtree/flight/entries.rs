//! Entries of the stacks of rays in flight.

use std::arch::x86_64::*;

use crate::structure::kdtree::treelet::{Child, WIDTH};

/// A cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Line([u8; 64]);

impl Line {
    pub(crate) const EMPTY: Self = Self([0; 64]);
}

/// Entries of the deepest stack, with room for one step's writing beyond it: a ray leaves at most
/// `WIDTH - 1` entries in each treelet, besides the first two.
pub(crate) fn stack_size(depth: usize) -> usize {
    2 + depth * (WIDTH - 1) + WIDTH
}

/// An entry of a stack and those after it: children with the spans in which the ray visits them.
#[derive(Clone, Copy)]
pub(crate) struct Entries {
    pub(crate) near: *mut f32,
    pub(crate) far: *mut f32,
    pub(crate) child: *mut Child,
}

impl Entries {
    /// The entry that is `count` further up.
    ///
    /// # Safety
    /// It is one of the stack.
    #[inline(always)]
    pub(crate) unsafe fn add(self, count: usize) -> Self {
        // SAFETY: the caller's.
        unsafe {
            Self {
                near: self.near.add(count),
                far: self.far.add(count),
                child: self.child.add(count),
            }
        }
    }

    /// # Safety
    /// It is an entry of a stack.
    #[inline(always)]
    pub(crate) unsafe fn set(self, [near, far]: [f32; 2], child: Child) {
        // SAFETY: the caller's.
        unsafe { (*self.near, *self.far, *self.child) = (near, far, child) }
    }

    /// Eight entries.
    ///
    /// # Safety
    /// The CPU has AVX2; there are eight.
    #[inline(always)]
    pub(crate) unsafe fn load(self) -> (__m256, __m256, __m256i) {
        // SAFETY: the caller's.
        unsafe {
            (
                _mm256_loadu_ps(self.near),
                _mm256_loadu_ps(self.far),
                _mm256_loadu_si256(self.child.cast()),
            )
        }
    }

    /// Writes eight entries.
    ///
    /// # Safety
    /// As [`load`](Self::load).
    #[inline(always)]
    pub(crate) unsafe fn store(self, near: __m256, far: __m256, child: __m256i) {
        // SAFETY: the caller's.
        unsafe {
            _mm256_storeu_ps(self.near, near);
            _mm256_storeu_ps(self.far, far);
            _mm256_storeu_si256(self.child.cast(), child);
        }
    }
}
