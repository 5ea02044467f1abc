//! Rays that have nothing in common, one to a lane, each on its own way down the tree.
//!
//! A step takes up to sixteen rays from a node to one of its children: the nodes, of 8 bytes each,
//! are gathered, so that sixteen loads are under way at once, and next to nothing depends on a branch
//! that the CPU would have to guess. What is left for later goes to stacks, one to a lane.
//! Lanes that reach a leaf wait until enough of them do; their leaves are then fetched together, and
//! tested sixteen triangles at once, those of up to four leaves ([`leaves`]).

mod leaves;
mod queue;

use std::arch::x86_64::*;
use std::mem::offset_of;

use super::leaf::Best;
use super::node::Node;
use super::ray::Prepared;
use super::{KdTree, Left, MAX_DEPTH, NO_HIT, packet};
use crate::accel::LANES;
use crate::accel::simd::lanes_of;
use leaves::Lists;
use queue::{Queue, Waiting};

/// Groups of sixteen rays under way: while one waits for memory, the others step.
const GROUPS: usize = 2;

/// Rays in nodes go on without those in leaves while there are so many of them.
const ENOUGH: u32 = 18;

/// Free lanes of a group are filled when there are so many of them.
const FREE: u32 = 4;

/// Below the bottom of each stack.
const DONE: u32 = u32::MAX;

/// Entries of a stack: its bottom, and one for each split on the way.
const ROWS: usize = MAX_DEPTH + 2;

/// Working memory.
#[derive(Debug)]
pub(super) struct Stream {
    groups: Box<[Group; GROUPS]>,
    queue: Box<Queue>,
    lists: Lists,
}

impl Default for Stream {
    fn default() -> Self {
        Self {
            groups: Box::new([Group::EMPTY; GROUPS]),
            queue: Box::new(Queue::EMPTY),
            lists: Lists::EMPTY,
        }
    }
}

/// Rays and where they stand, as structures of arrays.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Flights<const N: usize> {
    rays: Prepared<N>,
    node: [u32; N],
    /// Place in the stack above which there is nothing.
    top: [u32; N],
    hit: [[f32; N]; 2],
    primitive: [u32; N],
}

impl<const N: usize> Flights<N> {
    const EMPTY: Self = Self {
        rays: Prepared::EMPTY,
        node: [Node::ROOT as u32; N],
        top: [1; N],
        hit: [[0.0; N]; 2],
        primitive: [NO_HIT; N],
    };

    /// How many arrays there are, all of them of 4 bytes a ray.
    const ROWS: usize = size_of::<Self>() / (4 * N);
}

/// Sixteen rays under way.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Group {
    flights: Flights<LANES>,
    /// The words of leaves.
    leaf: [[u32; LANES]; 2],
    /// Lanes that stand before nodes, before leaves, and those that are to take what is on their
    /// stack; the others are free.
    stepping: u32,
    in_leaves: u32,
    stopped: u32,
    stack: [[Entry; LANES]; ROWS],
}

/// A part of the tree and of a ray, for later.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
struct Entry {
    node: u32,
    near: f32,
    far: f32,
    _pad: u32,
}

impl Entry {
    /// Always taken, as the last.
    const BOTTOM: Self = Self { node: DONE, near: f32::NEG_INFINITY, far: f32::INFINITY, _pad: 0 };
}

impl Group {
    const EMPTY: Self = Self {
        flights: Flights::EMPTY,
        leaf: [[0; LANES]; 2],
        stepping: 0,
        in_leaves: 0,
        stopped: 0,
        stack: [[Entry::BOTTOM; LANES]; ROWS],
    };
}

/// The nearest hit of rays, of `ANY` the first that is found; with `packets` those that go the same
/// way are traced together as long as that is worth its while.
///
/// # Safety
/// The CPU has AVX-512 F, BW, DQ, VL, AVX2, and FMA.
#[inline(always)]
pub(super) unsafe fn trace<const ANY: bool>(
    tree: &KdTree,
    left: Left,
    packets: Option<&mut packet::Stack>,
    stream: &mut Stream,
    done: &mut impl FnMut(usize, &Best),
) {
    let Stream { groups, queue, lists } = stream;
    let rays = left.rays;
    let mut waiting = Waiting { left, queue, from: 0, len: 0, packets };
    // SAFETY: the caller's.
    unsafe {
        loop {
            let (mut stepping, mut others) = (0, 0);
            for group in groups.iter_mut() {
                let under_way = group.stepping | group.in_leaves | group.stopped;
                if LANES as u32 - under_way.count_ones() >= FREE || under_way == 0 {
                    waiting.refill::<ANY>(tree, group, !under_way & 0xffff, done);
                }
                stepping += group.stepping.count_ones();
                others += (group.in_leaves | group.stopped).count_ones();
            }
            if stepping + others == 0 {
                return;
            }
            loop {
                let (mut stepping, mut others) = (0, 0);
                for group in groups.iter_mut() {
                    group.step(tree);
                    stepping += group.stepping.count_ones();
                    others += (group.in_leaves | group.stopped).count_ones();
                }
                if stepping < ENOUGH && others > 0 {
                    break;
                }
            }
            for group in groups.iter_mut() {
                group.prefetch_leaves(tree);
            }
            leaves::visit::<ANY>(groups, lists, tree, rays, done);
            for group in groups.iter_mut() {
                group.pop(done);
            }
        }
    }
}

#[inline(always)]
unsafe fn lane_numbers() -> __m512i {
    // SAFETY: the caller's.
    unsafe { _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15) }
}

#[inline(always)]
unsafe fn splat(x: u32) -> __m512i {
    // SAFETY: the caller's.
    unsafe { _mm512_set1_epi32(x as i32) }
}

#[inline(always)]
unsafe fn get(row: &[u32; LANES]) -> __m512i {
    // SAFETY: the caller's.
    unsafe { _mm512_loadu_si512(row.as_ptr().cast()) }
}

#[inline(always)]
unsafe fn get_ps(row: &[f32; LANES]) -> __m512 {
    // SAFETY: the caller's.
    unsafe { _mm512_loadu_ps(row.as_ptr()) }
}

/// Writes the lanes of a set. All lanes are stored: a load after a masked store would have to wait
/// until the store has reached the cache.
#[inline(always)]
unsafe fn put(row: &mut [u32; LANES], set: u16, values: __m512i) {
    // SAFETY: the caller's.
    unsafe {
        let all = _mm512_mask_mov_epi32(get(row), set, values);
        _mm512_storeu_si512(row.as_mut_ptr().cast(), all);
    }
}

#[inline(always)]
unsafe fn put_ps(row: &mut [f32; LANES], set: u16, values: __m512) {
    // SAFETY: the caller's.
    unsafe { _mm512_storeu_ps(row.as_mut_ptr(), _mm512_mask_mov_ps(get_ps(row), set, values)) }
}

/// The row of each lane's axis.
#[inline(always)]
unsafe fn by_axis(rows: &[[f32; LANES]; 3], y: u16, z: u16) -> __m512 {
    // SAFETY: the caller's.
    unsafe {
        let x_or_y = _mm512_mask_mov_ps(get_ps(&rows[0]), y, get_ps(&rows[1]));
        _mm512_mask_mov_ps(x_or_y, z, get_ps(&rows[2]))
    }
}

impl Group {
    /// Takes the lanes that stand before nodes a step further.
    ///
    /// # Safety
    /// As [`trace`].
    #[inline(always)]
    unsafe fn step(&mut self, tree: &KdTree) {
        let stepping = self.stepping as u16;
        // SAFETY: lanes stand before nodes of the tree; no way has more splits than the stacks
        // have rows.
        unsafe {
            let node = get(&self.flights.node);
            let nodes = tree.nodes.as_ptr().cast::<i64>();
            let zero = _mm512_setzero_si512();
            let low = _mm512_castsi512_si256(node);
            let high = _mm512_extracti64x4_epi64::<1>(node);
            let low = _mm512_mask_i32gather_epi64::<8>(zero, stepping as u8, low, nodes);
            let high = _mm512_mask_i32gather_epi64::<8>(zero, (stepping >> 8) as u8, high, nodes);
            let even = _mm512_slli_epi32::<1>(lane_numbers());
            let odd = _mm512_or_si512(even, _mm512_set1_epi32(1));
            let word0 = _mm512_permutex2var_epi32(low, even, high);
            let word1 = _mm512_permutex2var_epi32(low, odd, high);
            let y = _mm512_test_epi32_mask(word1, _mm512_set1_epi32(1));
            let z = _mm512_test_epi32_mask(word1, _mm512_set1_epi32(2));
            let leaves = stepping & y & z;
            let inner = stepping & !leaves;
            put(&mut self.leaf[0], leaves, word0);
            put(&mut self.leaf[1], leaves, word1);

            let inverse = by_axis(&self.flights.rays.inverse, y, z);
            let falls = _mm512_movepi32_mask(_mm512_castps_si512(inverse));
            // Offsets of leaves, taken for numbers, are subnormal: many times slower on some CPUs.
            let position = _mm512_castsi512_ps(_mm512_maskz_mov_epi32(inner, word0));
            let early = _mm512_fmsub_ps(position, inverse, by_axis(&self.flights.rays.early, y, z));
            let late = _mm512_fmsub_ps(position, inverse, by_axis(&self.flights.rays.late, y, z));
            let lower_is_empty = _mm512_test_epi32_mask(word1, splat(Node::LOWER_IS_EMPTY));
            let upper_is_empty = _mm512_test_epi32_mask(word1, splat(Node::UPPER_IS_EMPTY));
            let first_is_empty = (lower_is_empty & !falls) | (upper_is_empty & falls);
            let second_is_empty = (lower_is_empty & falls) | (upper_is_empty & !falls);
            let pair = _mm512_srli_epi32::<{ Node::PAIR_SHIFT }>(word1);
            let lower = _mm512_add_epi32(pair, pair);
            let one = _mm512_set1_epi32(1);
            let first = _mm512_mask_add_epi32(lower, falls, lower, one);
            let second = _mm512_xor_si512(first, one);

            let (near, far) = (get_ps(&self.flights.rays.near), get_ps(&self.flights.rays.far));
            // So written that NaN skips nothing.
            let visit_near = _mm512_cmp_ps_mask::<_CMP_NGT_UQ>(near, late);
            let visit_near = visit_near & inner & !first_is_empty;
            let visit_far = _mm512_cmp_ps_mask::<_CMP_NLT_UQ>(far, early);
            let visit_far = visit_far & inner & !second_is_empty;
            let both = visit_near & visit_far;
            let entered = _mm512_max_ps(early, near);
            if both != 0 {
                self.push(u32::from(both), second, entered);
            }
            put_ps(&mut self.flights.rays.far, visit_near, _mm512_min_ps(late, far));
            put_ps(&mut self.flights.rays.near, visit_far & !visit_near, entered);
            let next = _mm512_mask_mov_epi32(second, visit_near, first);
            put(&mut self.flights.node, inner, next);
            self.stepping = u32::from(visit_near | visit_far);
            self.in_leaves |= u32::from(leaves);
            self.stopped |= u32::from(inner) & !self.stepping;
        }
    }

    /// Puts entries on the stacks of some lanes; they end where the lanes' parts of the tree do.
    ///
    /// # Safety
    /// As [`trace`].
    #[inline(always)]
    unsafe fn push(&mut self, lanes: u32, node: __m512i, near: __m512) {
        let mut entries = [Entry::BOTTOM; LANES];
        // SAFETY: rows have places for all lanes, and no stack has more entries than rows.
        unsafe {
            let (near, far) = (_mm512_castps_si512(near), get(as_bits(&self.flights.rays.far)));
            let low = _mm512_unpacklo_epi32(node, near);
            let high = _mm512_unpackhi_epi32(node, near);
            let (far_low, far_high) =
                (_mm512_unpacklo_epi32(far, far), _mm512_unpackhi_epi32(far, far));
            let to = entries.as_mut_ptr().cast::<__m512i>();
            _mm512_storeu_si512(to.cast(), _mm512_unpacklo_epi64(low, far_low));
            _mm512_storeu_si512(to.add(1).cast(), _mm512_unpackhi_epi64(low, far_low));
            _mm512_storeu_si512(to.add(2).cast(), _mm512_unpacklo_epi64(high, far_high));
            _mm512_storeu_si512(to.add(3).cast(), _mm512_unpackhi_epi64(high, far_high));
            for lane in lanes_of(lanes) {
                let top = self.flights.top[lane] as usize % ROWS;
                self.stack[top][lane] = entries[lane % 4 * 4 + lane / 4];
            }
            let top = get(&self.flights.top);
            put(&mut self.flights.top, lanes as u16, _mm512_add_epi32(top, _mm512_set1_epi32(1)));
        }
    }

    /// Asks for the memory of the leaves.
    ///
    /// # Safety
    /// As [`trace`].
    #[inline(always)]
    unsafe fn prefetch_leaves(&self, tree: &KdTree) {
        for lane in lanes_of(self.in_leaves) {
            let words = tree.arena.words.as_ptr().wrapping_add(self.leaf[0][lane] as usize);
            for line in 0..5 {
                // SAFETY: a prefetch reads nothing.
                unsafe {
                    _mm_prefetch::<_MM_HINT_T0>(words.cast::<i8>().wrapping_add(64 * line));
                }
            }
        }
    }

    /// The nearest hit of a lane so far.
    #[inline(always)]
    fn best(&self, lane: usize) -> Best {
        let (u, v) = (self.flights.hit[0][lane], self.flights.hit[1][lane]);
        Best { t: self.flights.rays.t[lane], u, v, primitive: self.flights.primitive[lane] }
    }

    #[inline(always)]
    fn set_best(&mut self, lane: usize, best: &Best) {
        self.flights.rays.t[lane] = best.t;
        (self.flights.hit[0][lane], self.flights.hit[1][lane]) = (best.u, best.v);
        self.flights.primitive[lane] = best.primitive;
    }

    /// Tells the hit of a lane that stands before a leaf, and frees it.
    #[inline(always)]
    fn finish(&mut self, lane: usize, done: &mut impl FnMut(usize, &Best)) {
        self.in_leaves &= !(1 << lane);
        done(self.flights.rays.index[lane] as usize, &self.best(lane));
    }

    /// Takes the last entries from the stacks. Lanes whose stack is empty are done; those whose
    /// entry lies behind a hit stop again.
    ///
    /// # Safety
    /// As [`trace`].
    #[inline(always)]
    unsafe fn pop(&mut self, done: &mut impl FnMut(usize, &Best)) {
        const WORDS: i32 = (size_of::<Entry>() / 4) as i32;
        let stopped = self.stopped as u16;
        // SAFETY: at the bottom of each stack is an entry that is always taken.
        let (taken, hits) = unsafe {
            let top = _mm512_sub_epi32(get(&self.flights.top), _mm512_set1_epi32(1));
            put(&mut self.flights.top, stopped, top);
            let row = _mm512_slli_epi32::<{ LANES.ilog2() }>(top);
            let place = _mm512_add_epi32(row, lane_numbers());
            let place = _mm512_mullo_epi32(place, _mm512_set1_epi32(WORDS));
            let words = self.stack.as_ptr().cast::<f32>();
            let zero = _mm512_setzero_ps();
            let t = get_ps(&self.flights.rays.t);
            let near = words.add(offset_of!(Entry, near) / 4);
            let near = _mm512_mask_i32gather_ps::<4>(zero, stopped, place, near);
            let taken = stopped & _mm512_cmp_ps_mask::<_CMP_NGT_UQ>(near, t);
            let far = words.add(offset_of!(Entry, far) / 4);
            let far = _mm512_mask_i32gather_ps::<4>(zero, taken, place, far);
            let node = words.add(offset_of!(Entry, node) / 4).cast::<i32>();
            let none = _mm512_setzero_si512();
            let node = _mm512_mask_i32gather_epi32::<4>(none, taken, place, node);
            put(&mut self.flights.node, taken, node);
            put_ps(&mut self.flights.rays.near, taken, near);
            put_ps(&mut self.flights.rays.far, taken, _mm512_min_ps(far, t));
            let done = _mm512_mask_cmpeq_epi32_mask(taken, node, _mm512_set1_epi32(DONE as i32));
            let no_hit = _mm512_set1_epi32(NO_HIT as i32);
            let hits = _mm512_mask_cmpneq_epi32_mask(done, get(&self.flights.primitive), no_hit);
            self.stepping |= u32::from(taken & !done);
            (taken, hits)
        };
        self.stopped &= !u32::from(taken);
        for lane in lanes_of(u32::from(hits)) {
            done(self.flights.rays.index[lane] as usize, &self.best(lane));
        }
    }
}

/// The bits of a row of numbers.
#[inline(always)]
fn as_bits(row: &[f32; LANES]) -> &[u32; LANES] {
    // SAFETY: any bits are a number, of the same size and alignment.
    unsafe { &*(&raw const *row).cast() }
}
