//! The stream's operations on AVX-512.

#![allow(clippy::undocumented_unsafe_blocks)] // the caller's promise, in each of them
#![allow(clippy::needless_range_loop)] // closures around intrinsics would become calls

use std::arch::x86_64::*;

use super::entries::Entries;
use super::ray::Ray;
use super::vector::{ShearedLanes, Vector};
use super::ways::{NEAR, TIMES, WAYS, axes, row};
use crate::primitives::triangle::lanes::sheared;
use crate::structure::kdtree::leaf::Chunk;
use crate::structure::kdtree::treelet::Treelet;
use crate::structure::shared::order::x86::Avx512 as Choices;

impl Vector for __m512 {
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
            // For each cell when the planes about it are crossed: the late time of those behind it,
            // the early time of those before.
            let first =
                _mm256_permutex2var_ps(early, _mm256_load_si256((&raw const TIMES).cast()), late);
            let second = _mm256_permutex2var_ps(early, _mm256_srli_epi32::<8>(ways), late);
            let third = _mm256_permutex2var_ps(early, _mm256_srli_epi32::<4>(ways), late);
            // So ordered that NaN bounds nothing.
            let near = _mm256_set1_ps(near);
            let near = _mm256_mask_max_ps(near, !NEAR[0], first, near);
            let near = _mm256_mask_max_ps(near, !NEAR[1], second, near);
            let near = _mm256_mask_max_ps(near, !NEAR[2], third, near);
            let far = _mm256_set1_ps(far);
            let far = _mm256_mask_min_ps(far, NEAR[0], first, far);
            let far = _mm256_mask_min_ps(far, NEAR[1], second, far);
            let far = _mm256_mask_min_ps(far, NEAR[2], third, far);
            let children = _mm256_load_si256(treelet.children.as_ptr().cast());
            let children = _mm256_maskz_mov_epi32(among, children);
            let children = _mm256_permutevar8x32_epi32(children, ways);
            let there = _mm256_test_epi32_mask(children, children);
            let met = _mm256_mask_cmp_ps_mask::<_CMP_LE_OQ>(there, near, far);
            to.store(
                _mm256_maskz_compress_ps(met, near),
                _mm256_maskz_compress_ps(met, far),
                _mm256_maskz_compress_epi32(met, children),
            );
            met.count_ones() as usize
        }
    }

    #[inline(always)]
    unsafe fn cull(stack: Entries, len: usize, t: f32) -> usize {
        let mut kept = 0;
        unsafe {
            let t = _mm256_set1_ps(t);
            for i in (0..len).step_by(8) {
                let (near, far, child) = stack.add(i).load();
                let present = (1u32 << (len - i).min(8)) - 1;
                let met = _mm256_mask_cmp_ps_mask::<_CMP_LE_OQ>(present as u8, near, t);
                stack.add(kept).store(
                    _mm256_maskz_compress_ps(met, near),
                    _mm256_maskz_compress_ps(met, _mm256_min_ps(far, t)),
                    _mm256_maskz_compress_epi32(met, child),
                );
                kept += met.count_ones() as usize;
            }
        }
        kept
    }

    #[inline(always)]
    unsafe fn least(self) -> Self {
        unsafe {
            let least = self.least_of_quads();
            let least = _mm512_min_ps(least, _mm512_shuffle_f32x4::<0b10_11_00_01>(least, least));
            _mm512_min_ps(least, _mm512_shuffle_f32x4::<0b01_00_11_10>(least, least))
        }
    }

    #[inline(always)]
    unsafe fn least_of_quads(self) -> Self {
        unsafe {
            let least = _mm512_min_ps(self, _mm512_permute_ps::<0b10_11_00_01>(self));
            _mm512_min_ps(least, _mm512_permute_ps::<0b01_00_11_10>(least))
        }
    }

    #[inline(always)]
    unsafe fn sheared_corners(
        words: *const u32,
        chunk: Chunk,
        ShearedLanes { axes, origin, shear }: ShearedLanes<Self>,
        _first: usize,
        _present: u32,
    ) -> [[Self; 3]; 3] {
        unsafe {
            let vertices = chunk.vertices();
            let rows = words.cast::<f32>();
            let rows = [
                rows.add(axes[0] * vertices),
                rows.add(axes[1] * vertices),
                rows.add(axes[2] * vertices),
            ];
            let first = _mm256_loadu_si256(words.add(chunk.corners_at()).cast());
            let places = places(_mm512_cvtepu16_epi32(first));
            let mut corners = [[_mm512_setzero_ps(); 3]; 3];
            // Vertices are sheared once, whatever number of triangles has them for a corner.
            let there = _bzhi_u32(u32::MAX, vertices as u32);
            let low = sheared(some3(rows, 0, there), origin, shear);
            if vertices <= 16 {
                for c in 0..3 {
                    for k in 0..3 {
                        corners[c][k] = _mm512_permutexvar_ps(places[c], low[k]);
                    }
                }
            } else {
                let high = sheared(some3(rows, 16, there >> 16), origin, shear);
                for c in 0..3 {
                    for k in 0..3 {
                        corners[c][k] = _mm512_permutex2var_ps(low[k], places[c], high[k]);
                    }
                }
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
        const { assert!(M == 4) };
        unsafe {
            let mut from = [std::ptr::null::<u32>(); M];
            for i in 0..M {
                from[i] = words[i].add(chunks[i].corners_at());
            }
            let low = _mm_unpacklo_epi64(
                _mm_loadl_epi64(from[0].cast()),
                _mm_loadl_epi64(from[1 % M].cast()),
            );
            let high = _mm_unpacklo_epi64(
                _mm_loadl_epi64(from[2 % M].cast()),
                _mm_loadl_epi64(from[3 % M].cast()),
            );
            let first = _mm512_cvtepu16_epi32(_mm256_set_m128i(high, low));
            // The vertices of each chunk have an equal share of both registers.
            const NTH: i32 = 8 * (1 | 1 << 5 | 1 << 10);
            let shares = _mm512_setr_epi32(
                0,
                0,
                0,
                0,
                NTH,
                NTH,
                NTH,
                NTH,
                2 * NTH,
                2 * NTH,
                2 * NTH,
                2 * NTH,
                3 * NTH,
                3 * NTH,
                3 * NTH,
                3 * NTH,
            );
            let places = places(_mm512_or_si512(first, shares));
            let mut corners = [[_mm512_setzero_ps(); 3]; 3];
            for k in 0..3 {
                let mut from = [std::ptr::null::<f32>(); M];
                for i in 0..M {
                    from[i] = words[i].cast::<f32>().add(axes[i][k] * chunks[i].vertices());
                }
                let low = _mm512_castps256_ps512(_mm256_loadu_ps(from[0]));
                let low = _mm512_insertf32x8::<1>(low, _mm256_loadu_ps(from[1 % M]));
                let high = _mm512_castps256_ps512(_mm256_loadu_ps(from[2 % M]));
                let high = _mm512_insertf32x8::<1>(high, _mm256_loadu_ps(from[3 % M]));
                for c in 0..3 {
                    corners[c][k] = choose([low, high], places[c], present);
                }
            }
            corners
        }
    }
}

/// Numbers of each of three rows, those of a set of sixteen from the `first` on, and 0.
#[inline(always)]
unsafe fn some3(rows: [*const f32; 3], first: usize, set: u32) -> [__m512; 3] {
    let set = set as u16;
    unsafe {
        [
            _mm512_maskz_loadu_ps(set, rows[0].add(first)),
            _mm512_maskz_loadu_ps(set, rows[1].add(first)),
            _mm512_maskz_loadu_ps(set, rows[2].add(first)),
        ]
    }
}

/// Places of the three corners, of which the first is in the lowest five bits.
#[inline(always)]
unsafe fn places(first: __m512i) -> [__m512i; 3] {
    unsafe { [first, _mm512_srli_epi32::<5>(first), _mm512_srli_epi32::<10>(first)] }
}

/// The coordinates at some places of two registers; 0 where no triangle is present.
#[inline(always)]
unsafe fn choose([low, high]: [__m512; 2], places: __m512i, present: u32) -> __m512 {
    unsafe { _mm512_maskz_permutex2var_ps(present as u16, low, places, high) }
}
