//! Large arrays on large pages.
//!
//! Rays touch an array of tens of megabytes at places that have nothing to do with each other; on
//! pages of 4 KiB the CPU then looks up most addresses in tables that are in memory themselves. Of
//! pages of 2 MiB it keeps what it has looked up.

/// Arrays of fewer bytes stay on the pages that they get.
const LARGE: usize = 4 << 20;

/// `len` times a value, on large pages if the system has them.
pub(super) fn filled<T: Clone>(value: T, len: usize) -> Vec<T> {
    let mut array = Vec::with_capacity(len);
    ask_for_large(&array);
    array.resize(len, value);
    array
}

/// Asks the system for large pages wherever nothing has been written to an array yet, which is so
/// for one of zeros that is new.
#[cfg(target_os = "linux")]
pub(super) fn ask_for_large<T>(array: &Vec<T>) {
    const MADV_HUGEPAGE: i32 = 14;
    advise(array, MADV_HUGEPAGE);
}

/// Tells the system what to do with an array's pages; that it refuses does no harm.
#[cfg(target_os = "linux")]
fn advise<T>(array: &Vec<T>, advice: i32) {
    unsafe extern "C" {
        fn madvise(start: *mut std::ffi::c_void, len: usize, advice: i32) -> i32;
    }
    // A multiple of what a page is on any system.
    const PAGE: usize = 1 << 16;
    let bytes = array.capacity() * size_of::<T>();
    if bytes < LARGE {
        return;
    }
    let start = array.as_ptr().cast::<u8>();
    let skip = start.align_offset(PAGE).min(bytes);
    let whole = (bytes - skip) / PAGE * PAGE;
    // SAFETY: the pages belong to the array, and neither advice that is given here changes what
    // they hold or who may use them.
    unsafe { madvise(start.wrapping_add(skip).cast_mut().cast(), whole, advice) };
}

/// Moves an array to large pages if the system can, for one that grew as it was written.
#[cfg(target_os = "linux")]
pub(super) fn collapse<T>(array: &Vec<T>) {
    const MADV_HUGEPAGE: i32 = 14;
    const MADV_COLLAPSE: i32 = 25;
    advise(array, MADV_HUGEPAGE);
    advise(array, MADV_COLLAPSE);
}

#[cfg(not(target_os = "linux"))]
pub(super) fn collapse<T>(_: &Vec<T>) {}

#[cfg(not(target_os = "linux"))]
pub(super) fn ask_for_large<T>(_: &Vec<T>) {}

#[cfg(test)]
mod tests {
    #[test]
    fn arrays_of_any_size_are_filled() {
        for len in [0, 1, 1000, 5_000_000] {
            let array = super::filled(7u32, len);
            assert!(array.len() == len && array.iter().all(|&x| x == 7));
        }
    }
}
