//! How rays are chosen on AVX2 and AVX-512.

use std::arch::x86_64::*;

use super::Choosing;
use crate::accel::LANES;

/// AVX2.
pub(in crate::accel) struct Avx2;

/// AVX-512.
pub(in crate::accel) struct Avx512;

impl Choosing for Avx2 {
    #[inline(always)]
    unsafe fn lanes_with(values: &[u8; LANES], value: u8) -> u32 {
        // SAFETY: there are sixteen values.
        unsafe { lanes_with(values, value) }
    }
}

impl Choosing for Avx512 {
    #[inline(always)]
    unsafe fn lanes_with(values: &[u8; LANES], value: u8) -> u32 {
        // SAFETY: there are sixteen values.
        unsafe { lanes_with(values, value) }
    }

    #[inline(always)]
    unsafe fn compress(first: u32, set: u32, to: *mut u32) {
        // SAFETY: the caller's.
        unsafe {
            let lanes = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
            let values = _mm512_add_epi32(_mm512_set1_epi32(first as i32), lanes);
            _mm512_storeu_si512(to.cast(), _mm512_maskz_compress_epi32(set as u16, values));
        }
    }

    #[inline(always)]
    unsafe fn gather(array: *const f32, indices: &[u32; LANES]) -> [f32; LANES] {
        let mut values = [0.0; LANES];
        // SAFETY: the caller's; both arrays have sixteen elements.
        unsafe {
            let indices = _mm512_loadu_si512(indices.as_ptr().cast());
            let gathered = _mm512_i32gather_ps::<4>(indices, array);
            _mm512_storeu_ps(values.as_mut_ptr(), gathered);
        }
        values
    }
}

/// # Safety
/// The CPU has SSE2.
#[inline(always)]
unsafe fn lanes_with(values: &[u8; LANES], value: u8) -> u32 {
    // SAFETY: there are sixteen values.
    unsafe {
        let values = _mm_loadu_si128(values.as_ptr().cast());
        _mm_movemask_epi8(_mm_cmpeq_epi8(values, _mm_set1_epi8(value as i8))) as u32
    }
}
