//! The stream's operations on AVX-512.

#![allow(clippy::undocumented_unsafe_blocks)] // the caller's promise, in each of them
#![allow(clippy::needless_range_loop)] // closures around intrinsics would become calls

use std::arch::x86_64::*;

use super::vector::Vector;
use crate::accel::kdtree::node::Chunk;
use crate::accel::kdtree::x86::{Avx512, sixteen};
use crate::accel::order::x86::Avx512 as Choices;

impl Vector<16> for __m512 {
    type Words = __m512i;
    type Set = u16;
    type Kernel = Avx512;
    type Choosing = Choices;

    #[inline(always)]
    unsafe fn set(bits: u32) -> u16 {
        bits as u16
    }

    #[inline(always)]
    unsafe fn bits(set: u16) -> u32 {
        u32::from(set)
    }

    #[inline(always)]
    unsafe fn lowest(set: u32, count: u32) -> u32 {
        unsafe { _pdep_u32((1 << count.min(31)) - 1, set) }
    }

    #[inline(always)]
    unsafe fn load_words(from: *const u32) -> __m512i {
        unsafe { _mm512_loadu_si512(from.cast()) }
    }

    #[inline(always)]
    unsafe fn store_words(words: __m512i, to: *mut u32) {
        unsafe { _mm512_storeu_si512(to.cast(), words) }
    }

    #[inline(always)]
    unsafe fn splat_words(word: u32) -> __m512i {
        unsafe { _mm512_set1_epi32(word as i32) }
    }

    #[inline(always)]
    unsafe fn words(self) -> __m512i {
        unsafe { _mm512_castps_si512(self) }
    }

    #[inline(always)]
    unsafe fn numbers(words: __m512i) -> Self {
        unsafe { _mm512_castsi512_ps(words) }
    }

    #[inline(always)]
    unsafe fn lane_numbers() -> __m512i {
        unsafe { _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15) }
    }

    #[inline(always)]
    unsafe fn add_words(a: __m512i, b: __m512i) -> __m512i {
        unsafe { _mm512_add_epi32(a, b) }
    }

    #[inline(always)]
    unsafe fn and_words(a: __m512i, b: __m512i) -> __m512i {
        unsafe { _mm512_and_si512(a, b) }
    }

    #[inline(always)]
    unsafe fn xor_words(a: __m512i, b: __m512i) -> __m512i {
        unsafe { _mm512_xor_si512(a, b) }
    }

    #[inline(always)]
    unsafe fn shift_left(words: __m512i, by: u32) -> __m512i {
        unsafe { _mm512_sllv_epi32(words, _mm512_set1_epi32(by as i32)) }
    }

    #[inline(always)]
    unsafe fn shift_right(words: __m512i, by: u32) -> __m512i {
        unsafe { _mm512_srlv_epi32(words, _mm512_set1_epi32(by as i32)) }
    }

    #[inline(always)]
    unsafe fn add_one(words: __m512i, set: u16) -> __m512i {
        unsafe { _mm512_mask_add_epi32(words, set, words, _mm512_set1_epi32(1)) }
    }

    #[inline(always)]
    unsafe fn take_one(words: __m512i, set: u16) -> __m512i {
        unsafe { _mm512_mask_sub_epi32(words, set, words, _mm512_set1_epi32(1)) }
    }

    #[inline(always)]
    unsafe fn with_bit(words: __m512i, bit: u32) -> u16 {
        unsafe { _mm512_test_epi32_mask(words, _mm512_set1_epi32(1 << bit)) }
    }

    #[inline(always)]
    unsafe fn equal_words(a: __m512i, b: __m512i) -> u16 {
        unsafe { _mm512_cmpeq_epi32_mask(a, b) }
    }

    #[inline(always)]
    unsafe fn at_most(a: __m512i, b: __m512i) -> u16 {
        unsafe { _mm512_cmple_epu32_mask(a, b) }
    }

    #[inline(always)]
    unsafe fn is_negative(self) -> u16 {
        unsafe { _mm512_movepi32_mask(_mm512_castps_si512(self)) }
    }

    #[inline(always)]
    unsafe fn not_above(self, other: Self, among: u16) -> u16 {
        unsafe { _mm512_mask_cmp_ps_mask::<_CMP_NGT_UQ>(among, self, other) }
    }

    #[inline(always)]
    unsafe fn not_below(self, other: Self, among: u16) -> u16 {
        unsafe { _mm512_mask_cmp_ps_mask::<_CMP_NLT_UQ>(among, self, other) }
    }

    #[inline(always)]
    unsafe fn choose(set: u16, a: Self, b: Self) -> Self {
        unsafe { _mm512_mask_mov_ps(a, set, b) }
    }

    #[inline(always)]
    unsafe fn choose_words(set: u16, a: __m512i, b: __m512i) -> __m512i {
        unsafe { _mm512_mask_mov_epi32(a, set, b) }
    }

    #[inline(always)]
    unsafe fn gather(from: *const u32, places: __m512i, set: u16) -> __m512i {
        unsafe {
            let none = _mm512_setzero_si512();
            _mm512_mask_i32gather_epi32::<4>(none, set, places, from.cast())
        }
    }

    #[inline(always)]
    unsafe fn gather_pairs(from: *const u32, places: __m512i, set: u16) -> [__m512i; 2] {
        unsafe {
            let none = _mm512_setzero_si512();
            let low = _mm512_castsi512_si256(places);
            let high = _mm512_extracti64x4_epi64::<1>(places);
            let from = from.cast();
            let low = _mm512_mask_i32gather_epi64::<8>(none, set as u8, low, from);
            let high = _mm512_mask_i32gather_epi64::<8>(none, (set >> 8) as u8, high, from);
            let even = _mm512_slli_epi32::<1>(Self::lane_numbers());
            let odd = _mm512_or_si512(even, _mm512_set1_epi32(1));
            [_mm512_permutex2var_epi32(low, even, high), _mm512_permutex2var_epi32(low, odd, high)]
        }
    }

    #[inline(always)]
    unsafe fn compress(self, set: u32) -> Self {
        unsafe { _mm512_maskz_compress_ps(set as u16, self) }
    }

    #[inline(always)]
    unsafe fn expand(self, set: u32, packed: Self) -> Self {
        unsafe { _mm512_mask_expand_ps(self, set as u16, packed) }
    }

    #[inline(always)]
    unsafe fn interleave([a, b, c, d]: [Self; 4]) -> [Self; 4] {
        unsafe {
            use _mm512_castps_pd as pd;
            let (low, high) = (pd(_mm512_unpacklo_ps(a, b)), pd(_mm512_unpackhi_ps(a, b)));
            let (low2, high2) = (pd(_mm512_unpacklo_ps(c, d)), pd(_mm512_unpackhi_ps(c, d)));
            [
                _mm512_castpd_ps(_mm512_unpacklo_pd(low, low2)),
                _mm512_castpd_ps(_mm512_unpackhi_pd(low, low2)),
                _mm512_castpd_ps(_mm512_unpacklo_pd(high, high2)),
                _mm512_castpd_ps(_mm512_unpackhi_pd(high, high2)),
            ]
        }
    }

    #[inline(always)]
    unsafe fn shares<const M: usize>(from: [*const f32; M]) -> Self {
        unsafe {
            let mut lanes = _mm512_set1_ps(*from[0]);
            for i in 1..M {
                let share = ((1u32 << (16 / M)) - 1) << (i * (16 / M));
                lanes = _mm512_mask_broadcastss_ps(lanes, share as u16, _mm_load_ss(from[i]));
            }
            lanes
        }
    }

    #[inline(always)]
    unsafe fn least_of_shares<const M: usize>(self) -> Self {
        unsafe {
            let least = _mm512_min_ps(self, _mm512_permute_ps::<0b10_11_00_01>(self));
            let mut least = _mm512_min_ps(least, _mm512_permute_ps::<0b01_00_11_10>(least));
            if M <= 2 {
                least = _mm512_min_ps(least, _mm512_shuffle_f32x4::<0b10_11_00_01>(least, least));
            }
            if M == 1 {
                least = _mm512_min_ps(least, _mm512_shuffle_f32x4::<0b01_00_11_10>(least, least));
            }
            least
        }
    }

    #[inline(always)]
    unsafe fn corners<const M: usize>(
        words: [*const u32; M],
        chunks: [Chunk; M],
        axes: [[usize; 3]; M],
        _first: usize,
        present: u32,
    ) -> [[Self; 3]; 3] {
        unsafe {
            if M == 1 {
                return sixteen(words[0], chunks[0], axes[0]);
            }
            let places = places(words, chunks);
            let places = [places, _mm512_srli_epi32::<5>(places), _mm512_srli_epi32::<10>(places)];
            // What is no triangle, taken for numbers, is subnormal: many times slower on some CPUs.
            let present = present as u16;
            let mut corners = [[_mm512_setzero_ps(); 3]; 3];
            for k in 0..3 {
                let [low, high] = vertices(words, chunks, axes, k);
                for c in 0..3 {
                    corners[c][k] = _mm512_maskz_permutex2var_ps(present, low, places[c], high);
                }
            }
            corners
        }
    }
}

/// In which lanes of two registers of vertices the corners of triangles are: five bits each. Of two
/// or four chunks.
#[inline(always)]
unsafe fn places<const M: usize>(words: [*const u32; M], chunks: [Chunk; M]) -> __m512i {
    unsafe {
        let mut from = [std::ptr::null(); M];
        for i in 0..M {
            from[i] = words[i].add(chunks[i].corners_at());
        }
        if M == 2 {
            let low = _mm_loadu_si128(from[0].cast());
            let high = _mm_loadu_si128(from[1 % M].cast());
            let first = _mm512_cvtepu16_epi32(_mm256_set_m128i(high, low));
            let other = 16 | 16 << 5 | 16 << 10;
            _mm512_mask_or_epi32(first, 0xff00, first, _mm512_set1_epi32(other))
        } else {
            let low = _mm_loadl_epi64(from[0].cast());
            let low = _mm_unpacklo_epi64(low, _mm_loadl_epi64(from[1 % M].cast()));
            let high = _mm_loadl_epi64(from[2 % M].cast());
            let high = _mm_unpacklo_epi64(high, _mm_loadl_epi64(from[3 % M].cast()));
            let first = _mm512_cvtepu16_epi32(_mm256_set_m128i(high, low));
            let nth = 1 | 1 << 5 | 1 << 10;
            let numbers = _mm512_srli_epi32::<2>(<__m512 as Vector<16>>::lane_numbers());
            let others = _mm512_mullo_epi32(numbers, _mm512_set1_epi32(8 * nth));
            _mm512_or_si512(first, others)
        }
    }
}

/// Coordinates of the vertices along the `k`-th axis: each of two or four chunks has an equal share.
#[inline(always)]
unsafe fn vertices<const M: usize>(
    words: [*const u32; M],
    chunks: [Chunk; M],
    axes: [[usize; 3]; M],
    k: usize,
) -> [__m512; 2] {
    unsafe {
        let mut from = [std::ptr::null(); M];
        for i in 0..M {
            from[i] = words[i].cast::<f32>().add(axes[i][k] * chunks[i].vertices());
        }
        if M == 2 {
            return [_mm512_loadu_ps(from[0]), _mm512_loadu_ps(from[1 % M])];
        }
        let low = _mm512_castps256_ps512(_mm256_loadu_ps(from[0]));
        let low = _mm512_insertf32x8::<1>(low, _mm256_loadu_ps(from[1 % M]));
        let high = _mm512_castps256_ps512(_mm256_loadu_ps(from[2 % M]));
        let high = _mm512_insertf32x8::<1>(high, _mm256_loadu_ps(from[3 % M]));
        [low, high]
    }
}
