//! How rays are chosen on AVX2 and AVX-512.

use std::arch::x86_64::*;

use super::Choosing;
use crate::rays::LANES;
use crate::simd::sets::LANES_OF;

/// AVX2.
pub(crate) struct Avx2;

/// AVX-512.
pub(crate) struct Avx512;

impl Choosing for Avx2 {
    #[inline(always)]
    unsafe fn lanes_with(values: &[u8; LANES], value: u8) -> u32 {
        // SAFETY: there are sixteen values.
        unsafe { lanes_with(values, value) }
    }

    #[inline(always)]
    unsafe fn compress(from: &[f32; LANES], set: u32, to: *mut f32) {
        let [low, high] = [set & 255, set >> 8 & 255];
        // SAFETY: the caller's; a half has eight numbers, and so many are written behind the first.
        unsafe {
            _mm256_storeu_ps(to, packed(from.as_ptr(), low));
            _mm256_storeu_ps(to.add(low.count_ones() as usize), packed(from.as_ptr().add(8), high));
        }
    }
}

/// Packs the numbers of a set, of eight, to the front in their order; the rest is undefined.
///
/// # Safety
/// The CPU has AVX2; there are eight.
#[inline(always)]
unsafe fn packed(from: *const f32, set: u32) -> __m256 {
    // SAFETY: the caller's.
    unsafe {
        let lanes = _mm_loadl_epi64(LANES_OF[set as usize % 256].as_ptr().cast());
        _mm256_permutevar8x32_ps(_mm256_loadu_ps(from), _mm256_cvtepu8_epi32(lanes))
    }
}

impl Choosing for Avx512 {
    #[inline(always)]
    unsafe fn lanes_with(values: &[u8; LANES], value: u8) -> u32 {
        // SAFETY: there are sixteen values.
        unsafe { lanes_with(values, value) }
    }

    #[inline(always)]
    unsafe fn compress_lanes(first: u32, set: u32, to: *mut u32) {
        // SAFETY: the caller's.
        unsafe {
            let lanes = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
            let values = _mm512_add_epi32(_mm512_set1_epi32(first as i32), lanes);
            _mm512_storeu_si512(to.cast(), _mm512_maskz_compress_epi32(set as u16, values));
        }
    }

    #[inline(always)]
    unsafe fn compress(from: &[f32; LANES], set: u32, to: *mut f32) {
        // SAFETY: the caller's.
        unsafe {
            let values = _mm512_loadu_ps(from.as_ptr());
            _mm512_storeu_ps(to, _mm512_maskz_compress_ps(set as u16, values));
        }
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
