//! The stream's operations on AVX2.

#![allow(clippy::undocumented_unsafe_blocks)] // the caller's promise, in each of them
#![allow(clippy::needless_range_loop)] // closures around intrinsics would become calls

use std::arch::x86_64::*;
use std::ops::{BitAnd, BitOr, Not};

use super::vector::Vector;
use crate::accel::kdtree::node::Chunk;
use crate::accel::kdtree::x86::{Avx2, eight};
use crate::accel::order::x86::Avx2 as Choices;
use crate::accel::simd::sets::{LANES_OF, RANKS_IN};

/// The lanes whose sign is set; the other bits mean nothing.
#[derive(Clone, Copy)]
pub(in crate::accel::kdtree) struct Signs(__m256);

impl BitAnd for Signs {
    type Output = Self;

    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        // SAFETY: sets are made by a CPU that has AVX2.
        unsafe { Self(_mm256_and_ps(self.0, other.0)) }
    }
}

impl BitOr for Signs {
    type Output = Self;

    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        // SAFETY: sets are made by a CPU that has AVX2.
        unsafe { Self(_mm256_or_ps(self.0, other.0)) }
    }
}

impl Not for Signs {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        // SAFETY: sets are made by a CPU that has AVX2.
        unsafe { Self(_mm256_xor_ps(self.0, _mm256_castsi256_ps(_mm256_set1_epi32(-1)))) }
    }
}

impl Signs {
    #[inline(always)]
    unsafe fn words(self) -> __m256i {
        unsafe { _mm256_castps_si256(self.0) }
    }

    /// 1 in the lanes of the set, 0 in the others.
    #[inline(always)]
    unsafe fn ones(self) -> __m256i {
        unsafe { _mm256_srli_epi32::<31>(self.words()) }
    }
}

/// A row of a table of sets.
#[inline(always)]
unsafe fn row_of(table: &[[u8; 8]; 256], set: u32) -> __m256i {
    unsafe { _mm256_cvtepu8_epi32(_mm_loadl_epi64(table[(set & 255) as usize].as_ptr().cast())) }
}

impl Vector<8> for __m256 {
    type Words = __m256i;
    type Set = Signs;
    type Kernel = Avx2;
    type Choosing = Choices;

    #[inline(always)]
    unsafe fn set(bits: u32) -> Signs {
        unsafe {
            let shifts = _mm256_setr_epi32(31, 30, 29, 28, 27, 26, 25, 24);
            let signs = _mm256_sllv_epi32(_mm256_set1_epi32(bits as i32), shifts);
            Signs(_mm256_castsi256_ps(signs))
        }
    }

    #[inline(always)]
    unsafe fn bits(set: Signs) -> u32 {
        unsafe { _mm256_movemask_ps(set.0) as u32 }
    }

    #[inline(always)]
    unsafe fn lowest(set: u32, count: u32) -> u32 {
        unsafe {
            let ranks = row_of(&RANKS_IN, set);
            let below = _mm256_cmpgt_epi32(_mm256_set1_epi32(count as i32), ranks);
            set & Self::bits(Signs(_mm256_castsi256_ps(below)))
        }
    }

    #[inline(always)]
    unsafe fn load_words(from: *const u32) -> __m256i {
        unsafe { _mm256_loadu_si256(from.cast()) }
    }

    #[inline(always)]
    unsafe fn store_words(words: __m256i, to: *mut u32) {
        unsafe { _mm256_storeu_si256(to.cast(), words) }
    }

    #[inline(always)]
    unsafe fn splat_words(word: u32) -> __m256i {
        unsafe { _mm256_set1_epi32(word as i32) }
    }

    #[inline(always)]
    unsafe fn words(self) -> __m256i {
        unsafe { _mm256_castps_si256(self) }
    }

    #[inline(always)]
    unsafe fn numbers(words: __m256i) -> Self {
        unsafe { _mm256_castsi256_ps(words) }
    }

    #[inline(always)]
    unsafe fn lane_numbers() -> __m256i {
        unsafe { _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7) }
    }

    #[inline(always)]
    unsafe fn add_words(a: __m256i, b: __m256i) -> __m256i {
        unsafe { _mm256_add_epi32(a, b) }
    }

    #[inline(always)]
    unsafe fn and_words(a: __m256i, b: __m256i) -> __m256i {
        unsafe { _mm256_and_si256(a, b) }
    }

    #[inline(always)]
    unsafe fn xor_words(a: __m256i, b: __m256i) -> __m256i {
        unsafe { _mm256_xor_si256(a, b) }
    }

    #[inline(always)]
    unsafe fn shift_left(words: __m256i, by: u32) -> __m256i {
        unsafe { _mm256_sllv_epi32(words, _mm256_set1_epi32(by as i32)) }
    }

    #[inline(always)]
    unsafe fn shift_right(words: __m256i, by: u32) -> __m256i {
        unsafe { _mm256_srlv_epi32(words, _mm256_set1_epi32(by as i32)) }
    }

    #[inline(always)]
    unsafe fn add_one(words: __m256i, set: Signs) -> __m256i {
        unsafe { _mm256_add_epi32(words, set.ones()) }
    }

    #[inline(always)]
    unsafe fn take_one(words: __m256i, set: Signs) -> __m256i {
        unsafe { _mm256_sub_epi32(words, set.ones()) }
    }

    #[inline(always)]
    unsafe fn with_bit(words: __m256i, bit: u32) -> Signs {
        unsafe { Signs(_mm256_castsi256_ps(Self::shift_left(words, 31 - bit))) }
    }

    #[inline(always)]
    unsafe fn equal_words(a: __m256i, b: __m256i) -> Signs {
        unsafe { Signs(_mm256_castsi256_ps(_mm256_cmpeq_epi32(a, b))) }
    }

    #[inline(always)]
    unsafe fn at_most(a: __m256i, b: __m256i) -> Signs {
        unsafe { !Signs(_mm256_castsi256_ps(_mm256_cmpgt_epi32(a, b))) }
    }

    #[inline(always)]
    unsafe fn is_negative(self) -> Signs {
        Signs(self)
    }

    #[inline(always)]
    unsafe fn not_above(self, other: Self, among: Signs) -> Signs {
        unsafe { among & Signs(_mm256_cmp_ps::<_CMP_NGT_UQ>(self, other)) }
    }

    #[inline(always)]
    unsafe fn not_below(self, other: Self, among: Signs) -> Signs {
        unsafe { among & Signs(_mm256_cmp_ps::<_CMP_NLT_UQ>(self, other)) }
    }

    #[inline(always)]
    unsafe fn choose(set: Signs, a: Self, b: Self) -> Self {
        unsafe { _mm256_blendv_ps(a, b, set.0) }
    }

    #[inline(always)]
    unsafe fn choose_words(set: Signs, a: __m256i, b: __m256i) -> __m256i {
        unsafe { Self::choose(set, Self::numbers(a), Self::numbers(b)).words() }
    }

    #[inline(always)]
    unsafe fn gather(from: *const u32, places: __m256i, set: Signs) -> __m256i {
        unsafe {
            let none = _mm256_setzero_si256();
            _mm256_mask_i32gather_epi32::<4>(none, from.cast(), places, set.words())
        }
    }

    #[inline(always)]
    unsafe fn gather_pairs(from: *const u32, places: __m256i, set: Signs) -> [__m256i; 2] {
        unsafe {
            // Lanes 0, 1, 4, 5, and then the others: halves of pairs come apart in order.
            const ORDER: i32 = 0b11_01_10_00;
            let places = _mm256_permute4x64_epi64::<ORDER>(places);
            let set = _mm256_permute4x64_epi64::<ORDER>(set.words());
            let none = _mm256_setzero_si256();
            let from = from.cast();
            let low = _mm256_mask_i32gather_epi64::<8>(
                none,
                from,
                _mm256_castsi256_si128(places),
                _mm256_cvtepi32_epi64(_mm256_castsi256_si128(set)),
            );
            let high = _mm256_mask_i32gather_epi64::<8>(
                none,
                from,
                _mm256_extracti128_si256::<1>(places),
                _mm256_cvtepi32_epi64(_mm256_extracti128_si256::<1>(set)),
            );
            let (low, high) = (_mm256_castsi256_ps(low), _mm256_castsi256_ps(high));
            let first = _mm256_shuffle_ps::<0b10_00_10_00>(low, high);
            let second = _mm256_shuffle_ps::<0b11_01_11_01>(low, high);
            [_mm256_castps_si256(first), _mm256_castps_si256(second)]
        }
    }

    #[inline(always)]
    unsafe fn compress(self, set: u32) -> Self {
        unsafe { _mm256_permutevar8x32_ps(self, row_of(&LANES_OF, set)) }
    }

    #[inline(always)]
    unsafe fn expand(self, set: u32, packed: Self) -> Self {
        unsafe {
            let packed = _mm256_permutevar8x32_ps(packed, row_of(&RANKS_IN, set));
            Self::choose(Self::set(set), self, packed)
        }
    }

    #[inline(always)]
    unsafe fn interleave([a, b, c, d]: [Self; 4]) -> [Self; 4] {
        unsafe {
            use _mm256_castps_pd as pd;
            let (low, high) = (pd(_mm256_unpacklo_ps(a, b)), pd(_mm256_unpackhi_ps(a, b)));
            let (low2, high2) = (pd(_mm256_unpacklo_ps(c, d)), pd(_mm256_unpackhi_ps(c, d)));
            [
                _mm256_castpd_ps(_mm256_unpacklo_pd(low, low2)),
                _mm256_castpd_ps(_mm256_unpackhi_pd(low, low2)),
                _mm256_castpd_ps(_mm256_unpacklo_pd(high, high2)),
                _mm256_castpd_ps(_mm256_unpackhi_pd(high, high2)),
            ]
        }
    }

    #[inline(always)]
    unsafe fn shares<const M: usize>(from: [*const f32; M]) -> Self {
        unsafe {
            match M {
                1 => _mm256_broadcast_ss(&*from[0]),
                2 => {
                    let high = _mm_broadcast_ss(&*from[1 % M]);
                    _mm256_set_m128(high, _mm_broadcast_ss(&*from[0]))
                }
                _ => {
                    let low = _mm_movelh_ps(_mm_load_ss(from[0]), _mm_load_ss(from[1 % M]));
                    let high = _mm_movelh_ps(_mm_load_ss(from[2 % M]), _mm_load_ss(from[3 % M]));
                    _mm256_moveldup_ps(_mm256_set_m128(high, low))
                }
            }
        }
    }

    #[inline(always)]
    unsafe fn least_of_shares<const M: usize>(self) -> Self {
        unsafe {
            let mut least = _mm256_min_ps(self, _mm256_permute_ps::<0b10_11_00_01>(self));
            if M <= 2 {
                least = _mm256_min_ps(least, _mm256_permute_ps::<0b01_00_11_10>(least));
            }
            if M == 1 {
                least = _mm256_min_ps(least, _mm256_permute2f128_ps::<1>(least, least));
            }
            least
        }
    }

    #[inline(always)]
    unsafe fn corners<const M: usize>(
        words: [*const u32; M],
        chunks: [Chunk; M],
        axes: [[usize; 3]; M],
        first: usize,
        present: u32,
    ) -> [[Self; 3]; 3] {
        unsafe {
            if M == 1 {
                return eight::<false>(words[0], chunks[0], axes[0], first);
            }
            // What is no triangle has the first vertex of its chunk for corners: what follows the
            // vertices, taken for numbers, is subnormal, many times slower on some CPUs.
            let present = _mm256_srai_epi32::<31>(Self::set(present).words());
            let places = _mm256_and_si256(places(words, chunks), present);
            let places = [places, _mm256_srli_epi32::<5>(places), _mm256_srli_epi32::<10>(places)];
            let mut corners = [[_mm256_setzero_ps(); 3]; 3];
            for k in 0..3 {
                let [low, high] = vertices(words, chunks, axes, k);
                for c in 0..3 {
                    let place = places[c];
                    corners[c][k] = if M == 2 {
                        let low = _mm256_permutevar8x32_ps(low, place);
                        let high = _mm256_permutevar8x32_ps(high, place);
                        _mm256_blend_ps::<0b1111_0000>(low, high)
                    } else {
                        let low = _mm256_permutevar_ps(low, place);
                        let high = _mm256_permutevar_ps(high, place);
                        _mm256_blend_ps::<0b1100_1100>(low, high)
                    };
                }
            }
            corners
        }
    }
}

/// In which places of their chunks' vertices the corners of triangles are: five bits each. Of two or
/// four chunks.
#[inline(always)]
unsafe fn places<const M: usize>(words: [*const u32; M], chunks: [Chunk; M]) -> __m256i {
    unsafe {
        let mut from = [std::ptr::null::<u32>(); M];
        for i in 0..M {
            from[i] = words[i].add(chunks[i].corners_at());
        }
        _mm256_cvtepu16_epi32(if M == 2 {
            let low = _mm_loadl_epi64(from[0].cast());
            _mm_unpacklo_epi64(low, _mm_loadl_epi64(from[1 % M].cast()))
        } else {
            let low = _mm_loadu_si32(from[0].cast());
            let low = _mm_unpacklo_epi32(low, _mm_loadu_si32(from[1 % M].cast()));
            let high = _mm_loadu_si32(from[2 % M].cast());
            let high = _mm_unpacklo_epi32(high, _mm_loadu_si32(from[3 % M].cast()));
            _mm_unpacklo_epi64(low, high)
        })
    }
}

/// Coordinates of the vertices along the `k`-th axis: eight of each of two chunks, or four of each of
/// four, of which the first and the third come first.
#[inline(always)]
unsafe fn vertices<const M: usize>(
    words: [*const u32; M],
    chunks: [Chunk; M],
    axes: [[usize; 3]; M],
    k: usize,
) -> [__m256; 2] {
    unsafe {
        let mut from = [std::ptr::null::<f32>(); M];
        for i in 0..M {
            from[i] = words[i].cast::<f32>().add(axes[i][k] * chunks[i].vertices());
        }
        if M == 2 {
            return [_mm256_loadu_ps(from[0]), _mm256_loadu_ps(from[1 % M])];
        }
        [
            _mm256_set_m128(_mm_loadu_ps(from[2 % M]), _mm_loadu_ps(from[0])),
            _mm256_set_m128(_mm_loadu_ps(from[3 % M]), _mm_loadu_ps(from[1 % M])),
        ]
    }
}
