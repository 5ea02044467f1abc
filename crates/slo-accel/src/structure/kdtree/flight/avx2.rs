//! The stream's operations on AVX2.

#![allow(clippy::undocumented_unsafe_blocks)] // the caller's promise, in each of them
#![allow(clippy::needless_range_loop)] // closures around intrinsics would become calls

use std::arch::x86_64::*;

use super::entries::Entries;
use super::ray::Ray;
use super::vector::{ShearedLanes, Vector};
use super::ways::{NEAR, WAYS, axes, row};
use crate::primitives::triangle::lanes::sheared;
use crate::simd::sets::LANES_OF;
use crate::structure::kdtree::leaf::Chunk;
use crate::structure::kdtree::treelet::{TOP, Treelet};
use crate::structure::shared::order::x86::Avx2 as Choices;

impl Vector for __m256 {
    type Choosing = Choices;

    #[inline(always)]
    unsafe fn children(
        treelet: &Treelet,
        ray: &Ray,
        [near, far]: [f32; 2],
        among: u8,
        to: Entries,
    ) -> usize {
        unsafe {
            let planes = _mm256_load_ps(treelet.planes.as_ptr());
            let axes = axes(treelet);
            let inverse = row(&ray.inverse, axes);
            let early = _mm256_fmsub_ps(planes, inverse, row(&ray.early, axes));
            let late = _mm256_fmsub_ps(planes, inverse, row(&ray.late, axes));
            let falls = _mm256_movemask_ps(inverse) as usize & (WAYS.0.len() - 1);
            let ways = _mm256_cvtepu16_epi32(_mm_load_si128(WAYS.0[falls].as_ptr().cast()));
            let span = (_mm256_set1_ps(near), _mm256_set1_ps(far));
            let top = _mm256_set1_epi32(TOP as i32);
            let span = narrowed::<{ NEAR[0] as i32 }>(span, early, late, top);
            let middle = _mm256_srli_epi32::<8>(ways);
            let span = narrowed::<{ NEAR[1] as i32 }>(span, early, late, middle);
            let last = _mm256_srli_epi32::<4>(ways);
            let (near, far) = narrowed::<{ NEAR[2] as i32 }>(span, early, late, last);
            let children = _mm256_load_si256(treelet.children.as_ptr().cast());
            let bits = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            let among = _mm256_and_si256(_mm256_set1_epi32(i32::from(among)), bits);
            let children = _mm256_and_si256(children, _mm256_cmpeq_epi32(among, bits));
            let children = _mm256_permutevar8x32_epi32(children, ways);
            let missing = _mm256_cmpeq_epi32(children, _mm256_setzero_si256());
            let met = _mm256_cmp_ps::<_CMP_LE_OQ>(near, far);
            let met = _mm256_andnot_ps(_mm256_castsi256_ps(missing), met);
            keep(to, near, far, children, _mm256_movemask_ps(met))
        }
    }

    #[inline(always)]
    unsafe fn cull(stack: Entries, len: usize, t: f32) -> usize {
        let mut kept = 0;
        unsafe {
            let t = _mm256_set1_ps(t);
            for i in (0..len).step_by(8) {
                let (near, far, child) = stack.add(i).load();
                let present = (1i32 << (len - i).min(8)) - 1;
                let met = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(near, t)) & present;
                kept += keep(stack.add(kept), near, _mm256_min_ps(far, t), child, met);
            }
        }
        kept
    }

    #[inline(always)]
    unsafe fn least(self) -> Self {
        unsafe {
            let least = self.least_of_quads();
            _mm256_min_ps(least, _mm256_permute2f128_ps::<1>(least, least))
        }
    }

    #[inline(always)]
    unsafe fn least_of_quads(self) -> Self {
        unsafe {
            let least = _mm256_min_ps(self, _mm256_permute_ps::<0b10_11_00_01>(self));
            _mm256_min_ps(least, _mm256_permute_ps::<0b01_00_11_10>(least))
        }
    }

    #[inline(always)]
    unsafe fn sheared_corners(
        words: *const u32,
        chunk: Chunk,
        ShearedLanes { axes, origin, shear }: ShearedLanes<Self>,
        first: usize,
        present: u32,
    ) -> [[Self; 3]; 3] {
        unsafe {
            let vertices = chunk.vertices();
            let corners = words.add(chunk.corners_at() + first / 2);
            let places = places(_mm_loadu_si128(corners.cast()), present);
            let mut corners = [[_mm256_setzero_ps(); 3]; 3];
            for k in 0..3 {
                let row = words.cast::<f32>().add(axes[k] * vertices);
                let (low, high) = (_mm256_loadu_ps(row), _mm256_loadu_ps(row.add(8)));
                for c in 0..3 {
                    corners[c][k] = if vertices <= 16 {
                        let is_high = _mm256_castsi256_ps(_mm256_slli_epi32::<28>(places[c]));
                        let low = _mm256_permutevar8x32_ps(low, places[c]);
                        let high = _mm256_permutevar8x32_ps(high, places[c]);
                        _mm256_blendv_ps(low, high, is_high)
                    } else {
                        let place = _mm256_and_si256(places[c], _mm256_set1_epi32(31));
                        _mm256_i32gather_ps::<4>(row, place)
                    };
                }
            }
            for c in 0..3 {
                corners[c] = sheared(corners[c], origin, shear);
            }
            corners
        }
    }

    #[inline(always)]
    unsafe fn corners_of_quads<const M: usize>(
        words: [*const u32; M],
        chunks: [Chunk; M],
        axes: [[usize; 3]; M],
        present: u32,
    ) -> [[Self; 3]; 3] {
        const { assert!(M == 2) };
        unsafe {
            let low = _mm_loadl_epi64(words[0].add(chunks[0].corners_at()).cast());
            let high = _mm_loadl_epi64(words[1 % M].add(chunks[1 % M].corners_at()).cast());
            let places = places(_mm_unpacklo_epi64(low, high), present);
            let mut corners = [[_mm256_setzero_ps(); 3]; 3];
            for k in 0..3 {
                let mut rows = [_mm256_setzero_ps(); M];
                for i in 0..M {
                    let row = words[i].cast::<f32>().add(axes[i][k] * chunks[i].vertices());
                    rows[i] = _mm256_loadu_ps(row);
                }
                for c in 0..3 {
                    let low = _mm256_permutevar8x32_ps(rows[0], places[c]);
                    let high = _mm256_permutevar8x32_ps(rows[1 % M], places[c]);
                    corners[c][k] = _mm256_blend_ps::<0b1111_0000>(low, high);
                }
            }
            corners
        }
    }
}

/// Spans of cells narrowed by the planes about them of one level, given by place: by the late time
/// of the planes behind the cells in `NEAR`, by the early time of the planes before the others.
#[inline(always)]
unsafe fn narrowed<const NEAR: i32>(
    (near, far): (__m256, __m256),
    early: __m256,
    late: __m256,
    places: __m256i,
) -> (__m256, __m256) {
    unsafe {
        let early = _mm256_permutevar8x32_ps(early, places);
        let late = _mm256_permutevar8x32_ps(late, places);
        // So ordered that NaN bounds nothing.
        let later = _mm256_max_ps(early, near);
        let sooner = _mm256_min_ps(late, far);
        (_mm256_blend_ps::<NEAR>(later, near), _mm256_blend_ps::<NEAR>(far, sooner))
    }
}

/// Stores the entries of a set, packed; returns their number.
#[inline(always)]
unsafe fn keep(to: Entries, near: __m256, far: __m256, child: __m256i, set: i32) -> usize {
    unsafe {
        let lanes = _mm_loadl_epi64(LANES_OF[set as usize & 255].as_ptr().cast());
        let lanes = _mm256_cvtepu8_epi32(lanes);
        to.store(
            _mm256_permutevar8x32_ps(near, lanes),
            _mm256_permutevar8x32_ps(far, lanes),
            _mm256_permutevar8x32_epi32(child, lanes),
        );
        set.count_ones() as usize
    }
}

/// Places of the three corners of triangles, 5 bits each; of those that are not present the first
/// vertex.
#[inline(always)]
unsafe fn places(corners: __m128i, present: u32) -> [__m256i; 3] {
    unsafe {
        let bits = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
        let present = _mm256_and_si256(_mm256_set1_epi32(present as i32), bits);
        let present = _mm256_cmpeq_epi32(present, bits);
        let first = _mm256_and_si256(_mm256_cvtepu16_epi32(corners), present);
        [first, _mm256_srli_epi32::<5>(first), _mm256_srli_epi32::<10>(first)]
    }
}
