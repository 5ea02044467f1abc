//! Leaves of several rays at once.
//!
//! Most leaves fill a part of a register only. Those with up to 4 triangles are tested four at a
//! time, each for its own ray, those with up to 8 two at a time: the vertices of all of them fill the
//! two registers of which a permutation takes the corners, as those of one full leaf do.

#![allow(clippy::needless_range_loop)] // closures around intrinsics would become calls

use std::arch::x86_64::*;
use std::mem::offset_of;

use super::{GROUPS, Group, get, lane_numbers, splat};
use crate::accel::kdtree::KdTree;
use crate::accel::kdtree::leaf::{Best, triangle_at};
use crate::accel::kdtree::node::{Chunk, Node};
use crate::accel::kdtree::ray::Prepared;
use crate::accel::kdtree::x86::Avx512;
use crate::accel::triangle::lanes::Tested;
use crate::accel::{LANES, Rays};

/// Lanes of all groups that stand before leaves, by how many are tested at once: 4, 2, or 1.
#[derive(Debug)]
pub(super) struct Lists {
    /// With room for a register beyond the last.
    lanes: [[u32; (GROUPS + 1) * LANES]; 3],
    lens: [usize; 3],
}

impl Lists {
    pub(super) const EMPTY: Self = Self { lanes: [[0; (GROUPS + 1) * LANES]; 3], lens: [0; 3] };

    /// Lists the lanes of all groups that stand before leaves.
    ///
    /// # Safety
    /// As [`trace`](super::trace).
    #[inline(always)]
    unsafe fn fill(&mut self, groups: &[Group; GROUPS]) {
        self.lens = [0; 3];
        for (g, group) in groups.iter().enumerate() {
            // SAFETY: the caller's; no list gets more lanes than there are, which leaves room for a
            // register.
            unsafe {
                let leaves = group.in_leaves as u16;
                let chunk = _mm512_srli_epi32::<2>(get(&group.leaf[1]));
                let triangles = _mm512_and_si512(chunk, splat(Chunk::TRIANGLES));
                let vertices = _mm512_and_si512(chunk, splat(Chunk::VERTICES));
                let whole = leaves & _mm512_testn_epi32_mask(chunk, splat(Chunk::FOLLOWED));
                let four = whole
                    & _mm512_cmple_epu32_mask(triangles, splat(4))
                    & _mm512_cmple_epu32_mask(vertices, splat(Chunk::vertices_bits(8)));
                let two = whole
                    & !four
                    & _mm512_cmple_epu32_mask(triangles, splat(8))
                    & _mm512_cmple_epu32_mask(vertices, splat(Chunk::vertices_bits(16)));
                let numbers = _mm512_add_epi32(lane_numbers(), splat((g * LANES) as u32));
                let sets = [four, two, leaves & !four & !two];
                for i in 0..3 {
                    let to = self.lanes[i].as_mut_ptr().add(self.lens[i]);
                    let listed = _mm512_maskz_compress_epi32(sets[i], numbers);
                    _mm512_storeu_si512(to.cast(), listed);
                    self.lens[i] += sets[i].count_ones() as usize;
                }
            }
        }
    }
}

/// Tests what is in the leaves; rays go on from there.
///
/// # Safety
/// As [`trace`](super::trace).
#[inline(always)]
pub(super) unsafe fn visit<const ANY: bool>(
    groups: &mut [Group; GROUPS],
    lists: &mut Lists,
    tree: &KdTree,
    rays: &Rays,
    done: &mut impl FnMut(usize, &Best),
) {
    // SAFETY: the caller's; lists are of leaves of their kinds.
    unsafe {
        lists.fill(groups);
        visit_each::<4, ANY>(groups, &lists.lanes[0][..lists.lens[0]], tree, rays, done);
        visit_each::<2, ANY>(groups, &lists.lanes[1][..lists.lens[1]], tree, rays, done);
        visit_each::<1, ANY>(groups, &lists.lanes[2][..lists.lens[2]], tree, rays, done);
    }
    for group in groups {
        group.stopped |= group.in_leaves;
        group.in_leaves = 0;
    }
}

/// Tests leaves, `N` at a time.
///
/// # Safety
/// As [`trace`](super::trace); the lanes stand before leaves of which `N` fit in a register.
#[inline(always)]
unsafe fn visit_each<const N: usize, const ANY: bool>(
    groups: &mut [Group; GROUPS],
    lanes: &[u32],
    tree: &KdTree,
    rays: &Rays,
    done: &mut impl FnMut(usize, &Best),
) {
    for some in lanes.chunks(N) {
        // SAFETY: the caller's.
        unsafe {
            let meeting = Meeting::<N>::new(groups, some, tree);
            let tested = meeting.test();
            if tested.hits != 0 {
                meeting.keep::<ANY>(tested, groups, done);
            }
            if N == 1 && meeting.chunks[0].is_followed() {
                test_rest::<ANY>(groups, meeting.at[0], meeting.chunks[0], tree, rays, done);
            }
        }
    }
}

/// `N` rays before leaves that fill a register together. Where there are fewer, the last is taken
/// again, and none of its triangles.
struct Meeting<const N: usize> {
    /// Group and lane.
    at: [[usize; 2]; N],
    /// The first row of each ray.
    rows: [*const f32; N],
    words: [*const u32; N],
    chunks: [Chunk; N],
    axes: [[usize; 3]; N],
    /// Lanes of the register that hold triangles.
    present: u32,
}

impl<const N: usize> Meeting<N> {
    /// Lanes of the register for each ray.
    const SHARE: usize = LANES / N;

    /// # Safety
    /// As [`visit_each`]; there is a lane.
    #[inline(always)]
    unsafe fn new(groups: &[Group; GROUPS], lanes: &[u32], tree: &KdTree) -> Self {
        let mut meeting = Self {
            at: [[0; 2]; N],
            rows: [std::ptr::null(); N],
            words: [std::ptr::null(); N],
            chunks: [Chunk::default(); N],
            axes: [[0; 3]; N],
            present: 0,
        };
        for i in 0..N {
            // SAFETY: leaves have offsets in the arena.
            unsafe {
                let number = *lanes.get_unchecked(i.min(lanes.len() - 1)) as usize;
                let (g, lane) = (number / LANES % GROUPS, number % LANES);
                let group = &groups[g];
                meeting.at[i] = [g, lane];
                meeting.rows[i] = (&raw const group.flights.rays).cast::<f32>().add(lane);
                meeting.words[i] = tree.arena.words.as_ptr().add(group.leaf[0][lane] as usize);
                let chunk = Node::of_words([0, group.leaf[1][lane]]).chunk();
                meeting.chunks[i] = chunk;
                meeting.axes[i] = group.flights.rays.axes(lane);
                let set = (1 << chunk.triangles()) - 1;
                meeting.present |= if i < lanes.len() { set << (i * Self::SHARE) } else { 0 };
            }
        }
        meeting
    }

    /// Tests each ray with the triangles of its leaf.
    ///
    /// # Safety
    /// As [`visit_each`].
    #[inline(always)]
    unsafe fn test(&self) -> Tested<__m512> {
        const ROW: usize = 4 * LANES;
        const ORIGIN: usize = offset_of!(Prepared<LANES>, origin) / ROW;
        const SHEAR: usize = offset_of!(Prepared<LANES>, shear) / ROW;
        const T: usize = offset_of!(Prepared<LANES>, t) / ROW;
        // SAFETY: rays have these rows.
        unsafe {
            let origin = [self.row(ORIGIN), self.row(ORIGIN + 1), self.row(ORIGIN + 2)];
            let shear = [self.row(SHEAR), self.row(SHEAR + 1), self.row(SHEAR + 2)];
            let t = self.row(T);
            Tested::without_branch(self.corners(), origin, shear, t, self.present)
        }
    }

    /// A number of each ray, in all of its lanes.
    ///
    /// # Safety
    /// As [`visit_each`].
    #[inline(always)]
    unsafe fn row(&self, row: usize) -> __m512 {
        // SAFETY: rays have that row.
        unsafe {
            let mut lanes = _mm512_set1_ps(*self.rows[0].add(row * LANES));
            for i in 1..N {
                let share = ((1u32 << Self::SHARE) - 1) << (i * Self::SHARE);
                let number = _mm_load_ss(self.rows[i].add(row * LANES));
                lanes = _mm512_mask_broadcastss_ps(lanes, share as u16, number);
            }
            lanes
        }
    }

    /// Corners of all triangles.
    ///
    /// # Safety
    /// As [`visit_each`].
    #[inline(always)]
    unsafe fn corners(&self) -> [[__m512; 3]; 3] {
        // SAFETY: a finished arena goes on for 64 words after the last chunk.
        unsafe {
            let places = self.places();
            let places = [places, _mm512_srli_epi32::<5>(places), _mm512_srli_epi32::<10>(places)];
            // What is no triangle, taken for numbers, is subnormal: many times slower on some CPUs.
            let present = self.present as u16;
            let mut corners = [[_mm512_setzero_ps(); 3]; 3];
            for k in 0..3 {
                let [low, high] = self.vertices(k);
                for c in 0..3 {
                    corners[c][k] = _mm512_maskz_permutex2var_ps(present, low, places[c], high);
                }
            }
            corners
        }
    }

    /// In which lanes of two registers of vertices a triangle's corners are: five bits each.
    ///
    /// # Safety
    /// As [`visit_each`].
    #[inline(always)]
    unsafe fn places(&self) -> __m512i {
        // SAFETY: words of a chunk come after its vertices.
        unsafe {
            let mut from = [std::ptr::null(); N];
            for i in 0..N {
                from[i] = self.words[i].add(self.chunks[i].corners_at());
            }
            match N {
                1 => _mm512_cvtepu16_epi32(_mm256_loadu_si256(from[0].cast())),
                2 => {
                    let low = _mm_loadu_si128(from[0].cast());
                    let high = _mm_loadu_si128(from[1 % N].cast());
                    let first = _mm512_cvtepu16_epi32(_mm256_set_m128i(high, low));
                    let other = 16 | 16 << 5 | 16 << 10;
                    _mm512_mask_or_epi32(first, 0xff00, first, _mm512_set1_epi32(other))
                }
                _ => {
                    let low = _mm_loadl_epi64(from[0].cast());
                    let low = _mm_unpacklo_epi64(low, _mm_loadl_epi64(from[1 % N].cast()));
                    let high = _mm_loadl_epi64(from[2 % N].cast());
                    let high = _mm_unpacklo_epi64(high, _mm_loadl_epi64(from[3 % N].cast()));
                    let first = _mm512_cvtepu16_epi32(_mm256_set_m128i(high, low));
                    let nth = 1 | 1 << 5 | 1 << 10;
                    let numbers = _mm512_srli_epi32::<2>(lane_numbers());
                    let others = _mm512_mullo_epi32(numbers, _mm512_set1_epi32(8 * nth));
                    _mm512_or_si512(first, others)
                }
            }
        }
    }

    /// Coordinates of the vertices along the `k`-th sheared axis: each ray has an equal share.
    ///
    /// # Safety
    /// As [`visit_each`].
    #[inline(always)]
    unsafe fn vertices(&self, k: usize) -> [__m512; 2] {
        // SAFETY: a finished arena goes on for 64 words after the last chunk.
        unsafe {
            let mut from = [std::ptr::null(); N];
            for i in 0..N {
                let row = self.axes[i][k] * self.chunks[i].vertices();
                from[i] = self.words[i].cast::<f32>().add(row);
            }
            match N {
                1 => [_mm512_loadu_ps(from[0]), _mm512_loadu_ps(from[0].add(LANES))],
                2 => [_mm512_loadu_ps(from[0]), _mm512_loadu_ps(from[1 % N])],
                _ => {
                    let low = _mm512_castps256_ps512(_mm256_loadu_ps(from[0]));
                    let low = _mm512_insertf32x8::<1>(low, _mm256_loadu_ps(from[1 % N]));
                    let high = _mm512_castps256_ps512(_mm256_loadu_ps(from[2 % N]));
                    let high = _mm512_insertf32x8::<1>(high, _mm256_loadu_ps(from[3 % N]));
                    [low, high]
                }
            }
        }
    }

    /// Keeps the nearest hit of each ray.
    ///
    /// # Safety
    /// As [`visit_each`].
    #[inline(always)]
    unsafe fn keep<const ANY: bool>(
        &self,
        tested: Tested<__m512>,
        groups: &mut [Group; GROUPS],
        done: &mut impl FnMut(usize, &Best),
    ) {
        // SAFETY: the caller's; arrays have sixteen places, and ids stand in the arena.
        unsafe {
            let tested = tested.settle(|lane| {
                let i = lane / Self::SHARE;
                let [g, at] = self.at[i];
                let words = std::slice::from_raw_parts(self.words[i], self.chunks[i].ids_at());
                let triangle = triangle_at(words, self.chunks[i], lane % Self::SHARE);
                (groups[g].flights.rays.line(at).sheared(), triangle)
            });
            let parts = tested.parts();
            let mut numbers = [[0.0f32; LANES]; 4];
            _mm512_storeu_ps(numbers[0].as_mut_ptr(), tested.t);
            for i in 0..3 {
                _mm512_storeu_ps(numbers[1 + i].as_mut_ptr(), parts[i]);
            }
            let mut nearest = tested.hits & nearest::<N>(tested.t, tested.hits as u16);
            while nearest != 0 {
                // The first of equals has the lowest id.
                let lane = nearest.trailing_zeros() as usize % LANES;
                let i = lane / Self::SHARE;
                nearest &= u32::MAX << ((i + 1) * Self::SHARE);
                let [g, at] = self.at[i];
                let group = &mut groups[g];
                let id = *self.words[i].add(self.chunks[i].ids_at() + lane % Self::SHARE);
                let t = numbers[0][lane];
                if t < group.flights.rays.t[at] || id < group.flights.primitive[at] {
                    let determinant = numbers[3][lane];
                    group.flights.rays.t[at] = t;
                    group.flights.hit[0][at] = numbers[1][lane] / determinant;
                    group.flights.hit[1][at] = numbers[2][lane] / determinant;
                    group.flights.primitive[at] = id;
                    if ANY {
                        group.finish(at, done);
                    }
                }
            }
        }
    }
}

/// Lanes whose distance is the least of their ray's hits, of `N` rays.
///
/// # Safety
/// The CPU has AVX-512.
#[inline(always)]
unsafe fn nearest<const N: usize>(t: __m512, hits: u16) -> u32 {
    // SAFETY: the caller's.
    unsafe {
        let t = _mm512_mask_mov_ps(_mm512_set1_ps(f32::INFINITY), hits, t);
        let least = _mm512_min_ps(t, _mm512_permute_ps::<0b10_11_00_01>(t));
        let mut least = _mm512_min_ps(least, _mm512_permute_ps::<0b01_00_11_10>(least));
        if N <= 2 {
            least = _mm512_min_ps(least, _mm512_shuffle_f32x4::<0b10_11_00_01>(least, least));
        }
        if N == 1 {
            least = _mm512_min_ps(least, _mm512_shuffle_f32x4::<0b01_00_11_10>(least, least));
        }
        u32::from(_mm512_cmp_ps_mask::<_CMP_EQ_OQ>(t, least))
    }
}

/// Tests what follows the first chunk of a leaf.
///
/// # Safety
/// As [`visit_each`].
#[inline(always)]
unsafe fn test_rest<const ANY: bool>(
    groups: &mut [Group; GROUPS],
    [g, at]: [usize; 2],
    chunk: Chunk,
    tree: &KdTree,
    rays: &Rays,
    done: &mut impl FnMut(usize, &Best),
) {
    let group = &mut groups[g];
    if group.in_leaves >> at & 1 == 0 {
        return;
    }
    let rest = &tree.arena.words[group.leaf[0][at] as usize + chunk.end()..];
    let line = group.flights.rays.line(at);
    let ray = (rays, group.flights.rays.index[at] as usize);
    let mut best = group.best(at);
    // SAFETY: the caller's.
    unsafe { tree.test_rest::<Avx512>(rest, chunk, &line, ray, &mut best) };
    let is_new = best.primitive != group.flights.primitive[at];
    group.set_best(at, &best);
    if ANY && is_new {
        group.finish(at, done);
    }
}
