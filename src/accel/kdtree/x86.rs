//! The test of a chunk's triangles on AVX2 and AVX-512.

#![allow(clippy::needless_range_loop)] // closures around intrinsics would become calls

use std::arch::x86_64::*;

use super::leaf::{Best, triangle_at};
use super::node::Chunk;
use super::ray::Line;
use super::single::Kernel;
use crate::accel::simd::Lanes;
use crate::accel::triangle::TriangleHit;
use crate::accel::triangle::lanes::Tested;

/// AVX2 with fused multiply-add: eight triangles at once.
pub(super) struct Avx2;

/// AVX-512: sixteen triangles at once.
pub(super) struct Avx512;

/// Corners of up to sixteen triangles of a chunk.
///
/// # Safety
/// The CPU has AVX-512; the words are those of a finished arena.
#[inline(always)]
pub(super) unsafe fn sixteen(
    words: *const u32,
    chunk: Chunk,
    axes: [usize; 3],
) -> [[__m512; 3]; 3] {
    let vertices = chunk.vertices();
    // SAFETY: a finished arena goes on for 64 words after the last chunk.
    unsafe {
        let p = words.cast::<f32>();
        // What follows, taken for numbers, is subnormal: many times slower on some CPUs.
        let present = ((1u32 << chunk.triangles()) - 1) as u16;
        let first = _mm512_cvtepu16_epi32(_mm256_loadu_si256(p.add(3 * vertices).cast()));
        let places = [first, _mm512_srli_epi32::<5>(first), _mm512_srli_epi32::<10>(first)];
        let mut corners = [[_mm512_setzero_ps(); 3]; 3];
        for k in 0..3 {
            let row = p.add(axes[k] * vertices);
            let (low, high) = (_mm512_loadu_ps(row), _mm512_loadu_ps(row.add(16)));
            for c in 0..3 {
                corners[c][k] = _mm512_maskz_permutex2var_ps(present, low, places[c], high);
            }
        }
        corners
    }
}

impl Kernel for Avx512 {
    #[inline(always)]
    unsafe fn test(words: &[u32], chunk: Chunk, line: &Line, best: &mut Best) {
        // SAFETY: the caller's.
        unsafe {
            let corners = sixteen(words.as_ptr(), chunk, line.axes);
            keep(test(corners, 0, chunk, line, best.t), 0, words, chunk, line, best);
        }
    }
}

/// Corners of up to eight triangles of a chunk, from the `first` on, which is even; it has no more than
/// sixteen vertices, or `MANY`.
///
/// # Safety
/// The CPU has AVX2; the words are those of a finished arena.
#[inline(always)]
pub(super) unsafe fn eight<const MANY: bool>(
    words: *const u32,
    chunk: Chunk,
    axes: [usize; 3],
    first: usize,
) -> [[__m256; 3]; 3] {
    let vertices = chunk.vertices();
    // SAFETY: a finished arena goes on for 64 words after the last chunk.
    unsafe {
        let p = words.cast::<f32>();
        let places = _mm_loadu_si128(p.add(chunk.corners_at() + first / 2).cast());
        let places = _mm256_cvtepu16_epi32(places);
        // No vertex but the first for triangles that the chunk does not have: what follows it, taken
        // for numbers, is subnormal, many times slower on some CPUs.
        let numbers = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
        let count = _mm256_set1_epi32(chunk.triangles() as i32 - first as i32);
        let places = _mm256_and_si256(places, _mm256_cmpgt_epi32(count, numbers));
        let places = [places, _mm256_srli_epi32::<5>(places), _mm256_srli_epi32::<10>(places)];
        let mut corners = [[_mm256_setzero_ps(); 3]; 3];
        for k in 0..3 {
            let row = p.add(axes[k] * vertices);
            if !MANY {
                let (low, high) = (_mm256_loadu_ps(row), _mm256_loadu_ps(row.add(8)));
                for c in 0..3 {
                    let is_high = _mm256_castsi256_ps(_mm256_slli_epi32::<28>(places[c]));
                    corners[c][k] = _mm256_blendv_ps(
                        _mm256_permutevar8x32_ps(low, places[c]),
                        _mm256_permutevar8x32_ps(high, places[c]),
                        is_high,
                    );
                }
            } else {
                for c in 0..3 {
                    let place = _mm256_and_si256(places[c], _mm256_set1_epi32(31));
                    corners[c][k] = _mm256_i32gather_ps::<4>(row, place);
                }
            }
        }
        corners
    }
}

impl Kernel for Avx2 {
    #[inline(always)]
    unsafe fn test(words: &[u32], chunk: Chunk, line: &Line, best: &mut Best) {
        // SAFETY: the caller's.
        unsafe {
            for base in (0..chunk.triangles()).step_by(8) {
                let corners = match chunk.vertices() {
                    ..=16 => eight::<false>(words.as_ptr(), chunk, line.axes, base),
                    _ => eight::<true>(words.as_ptr(), chunk, line.axes, base),
                };
                let tested = test(corners, base, chunk, line, best.t);
                keep(tested, base, words, chunk, line, best);
            }
        }
    }
}

/// Tests the triangles from `base` on, whose corners are given, up to `t`.
///
/// # Safety
/// The CPU has the instructions of `L`.
#[inline(always)]
pub(super) unsafe fn test<L: Lanes>(
    corners: [[L; 3]; 3],
    base: usize,
    chunk: Chunk,
    line: &Line,
    t: f32,
) -> Tested<L> {
    // SAFETY: the caller's.
    unsafe {
        let (o, s) = (&line.origin, &line.shear);
        let origin = [L::splat(o[0]), L::splat(o[1]), L::splat(o[2])];
        let shear = [L::splat(s[0]), L::splat(s[1]), L::splat(s[2])];
        let present = (1u32 << (chunk.triangles() - base).min(L::COUNT)) - 1;
        Tested::without_branch(corners, origin, shear, L::splat(t), present)
    }
}

/// Keeps the nearest hit of the triangles from `base` on.
///
/// # Safety
/// The CPU has the instructions of `L`; the words are those of the chunk.
#[inline(always)]
pub(super) unsafe fn keep<L: Lanes>(
    tested: Tested<L>,
    base: usize,
    words: &[u32],
    chunk: Chunk,
    line: &Line,
    best: &mut Best,
) {
    if tested.hits == 0 {
        return;
    }
    // SAFETY: the arrays have as many elements as there are lanes, or more; an arena holds an id
    // for each triangle of a chunk.
    unsafe {
        let tested = tested.settle(|lane| (line.sheared(), triangle_at(words, chunk, base + lane)));
        let mut lanes = [[0.0f32; 16]; 3];
        let [u, v] = tested.weights();
        tested.t.store(lanes[0].as_mut_ptr());
        u.store(lanes[1].as_mut_ptr());
        v.store(lanes[2].as_mut_ptr());
        let mut hits = tested.hits;
        while hits != 0 {
            let lane = hits.trailing_zeros() as usize & 15;
            hits &= hits - 1;
            let hit = TriangleHit { t: lanes[0][lane], u: lanes[1][lane], v: lanes[2][lane] };
            best.offer(hit, *words.get_unchecked(chunk.ids_at() + base + lane));
        }
    }
}
