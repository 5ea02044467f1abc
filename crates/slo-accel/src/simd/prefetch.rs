//! Asking for memory before it is read.

/// Asks for the cache line of an address, which need not be readable: for the first level of the
/// cache, or if `FAR` for the second.
#[inline(always)]
pub(crate) fn prefetch<const FAR: bool>(at: *const u8) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _MM_HINT_T1, _mm_prefetch};
        // SAFETY: a prefetch reads nothing.
        unsafe {
            if FAR {
                _mm_prefetch::<_MM_HINT_T1>(at.cast());
            } else {
                _mm_prefetch::<_MM_HINT_T0>(at.cast());
            }
        }
    }
    #[cfg(target_arch = "aarch64")]
    {
        use std::arch::asm;
        let at = at.addr();
        // SAFETY: a prefetch reads nothing, and changes no register and no flag.
        unsafe {
            if FAR {
                asm!("prfm pldl2keep, [{}]", in(reg) at, options(nomem, nostack, preserves_flags));
            } else {
                asm!("prfm pldl1keep, [{}]", in(reg) at, options(nomem, nostack, preserves_flags));
            }
        }
    }
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    let _ = at;
}
