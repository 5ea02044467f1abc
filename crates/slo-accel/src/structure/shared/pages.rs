//! Large arrays on large pages.
//!
//! Rays touch an array of tens of megabytes at unrelated places. With pages of 4 KiB the CPU then
//! looks up most addresses in page tables, which are in memory themselves; with pages of 2 MiB its
//! cache of addresses is large enough.

use std::alloc::{Layout, alloc, dealloc, handle_alloc_error};
use std::mem::MaybeUninit;
use std::ops::{Deref, DerefMut};
use std::ptr::NonNull;

use rayon::prelude::*;

/// Bytes of a large page, which is aligned to its size.
const LARGE_PAGE: usize = 2 << 20;

/// An array of a fixed length. It lies on large pages if it fills at least half of one and the
/// system has them.
pub(crate) struct Array<T> {
    start: NonNull<T>,
    len: usize,
}

impl<T: Copy + Send + Sync> Array<T> {
    /// `len` times a value. All threads of the current pool fill a large array: its pages are cleared
    /// when they are first touched, which takes longer than to fill them.
    pub(crate) fn filled(value: T, len: usize) -> Self {
        let layout = Self::layout(len);
        if layout.size() == 0 {
            return Self { start: NonNull::dangling(), len };
        }
        // SAFETY: the size is not 0; what is filled lies within what was given.
        unsafe {
            let Some(start) = NonNull::new(alloc(layout).cast::<T>()) else {
                handle_alloc_error(layout)
            };
            #[cfg(target_os = "linux")]
            if layout.align() == LARGE_PAGE {
                // What lies behind the array on its last page keeps its values.
                let bytes = (layout.size() + LARGE_PAGE / 2) / LARGE_PAGE * LARGE_PAGE;
                madvise(start.as_ptr().cast(), bytes, MADV_HUGEPAGE);
            }
            let start_of_all = start.as_ptr().cast::<MaybeUninit<T>>();
            let all = std::slice::from_raw_parts_mut(start_of_all, len);
            all.par_chunks_mut((LARGE_PAGE / size_of::<T>()).max(1))
                .for_each(|page| page.fill(MaybeUninit::new(value)));
            Self { start, len }
        }
    }
}

impl<T> Array<T> {
    fn layout(len: usize) -> Layout {
        let layout = Layout::array::<T>(len).expect("less than all of memory");
        let is_large = layout.size() >= LARGE_PAGE / 2;
        let align = if is_large { LARGE_PAGE } else { layout.align() };
        layout.align_to(align).expect("less than all of memory")
    }
}

/// Types that are nothing but their bytes.
///
/// # Safety
/// The type has no padding, and any bytes are a value of it.
pub(crate) unsafe trait Plain: Copy {}

// SAFETY: numbers.
unsafe impl Plain for u32 {}
// SAFETY: nine numbers.
unsafe impl Plain for crate::primitives::Triangle {}

/// The bytes of plain values, as they lie in memory.
pub(crate) fn bytes_of<T: Plain>(values: &[T]) -> &[u8] {
    // SAFETY: all bytes of plain values are initialised.
    unsafe { std::slice::from_raw_parts(values.as_ptr().cast(), size_of_val(values)) }
}

/// The same bytes, to be changed.
pub(crate) fn bytes_of_mut<T: Plain>(values: &mut [T]) -> &mut [u8] {
    // SAFETY: as above; any bytes make plain values.
    unsafe { std::slice::from_raw_parts_mut(values.as_mut_ptr().cast(), size_of_val(values)) }
}

impl<T> Drop for Array<T> {
    fn drop(&mut self) {
        let layout = Self::layout(self.len);
        if layout.size() != 0 {
            // SAFETY: it was allocated so, and elements are `Copy`.
            unsafe { dealloc(self.start.as_ptr().cast(), layout) };
        }
    }
}

// SAFETY: it owns its elements, as a `Vec` does.
unsafe impl<T: Send> Send for Array<T> {}
// SAFETY: as above.
unsafe impl<T: Sync> Sync for Array<T> {}

impl<T> Deref for Array<T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        // SAFETY: all elements were filled.
        unsafe { std::slice::from_raw_parts(self.start.as_ptr(), self.len) }
    }
}

impl<T> DerefMut for Array<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        // SAFETY: all elements were filled.
        unsafe { std::slice::from_raw_parts_mut(self.start.as_ptr(), self.len) }
    }
}

impl<T> Default for Array<T> {
    fn default() -> Self {
        Self { start: NonNull::dangling(), len: 0 }
    }
}

impl<T> std::fmt::Debug for Array<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} elements", self.len)
    }
}

#[cfg(target_os = "linux")]
const MADV_HUGEPAGE: i32 = 14;

#[cfg(target_os = "linux")]
unsafe extern "C" {
    fn madvise(start: *mut std::ffi::c_void, len: usize, advice: i32) -> i32;
}

#[cfg(test)]
mod tests {
    #[test]
    fn arrays_of_any_size_are_filled() {
        for len in [0, 1, 1000, 300_000, 600_000, 5_000_000] {
            let mut array = super::Array::filled(7u32, len);
            assert!(array.len() == len && array.iter().all(|&x| x == 7));
            array.fill(8);
            assert!(array.iter().all(|&x| x == 8));
        }
    }
}
