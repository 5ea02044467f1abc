//! Rays that have nothing in common, one to a lane, each on its own way down the tree.
//!
//! A step takes up to sixteen rays from a node to one of its children: the nodes, of 8 bytes each,
//! are gathered, so that sixteen loads are under way at once, and next to nothing depends on a branch
//! that the CPU would have to guess. What is left for later goes to stacks, one to a lane.
//! Lanes that reach a leaf wait until enough of them do; their leaves are then fetched together, and
//! tested one after the other, sixteen triangles at once.

use std::arch::x86_64::*;
use std::mem::MaybeUninit;

use super::leaf::Best;
use super::node::Node;
use super::ray::Prepared;
use super::x86::{self, Avx512};
use super::{KdTree, MAX_DEPTH, NO_HIT};
use crate::accel::simd::lanes_of;
use crate::accel::triangle::lanes::Tested;
use crate::accel::triangle::turned::smaller;
use crate::accel::{LANES, Rays};

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
    queue: Box<Prepared<{ 2 * LANES }>>,
}

impl Default for Stream {
    fn default() -> Self {
        Self { groups: Box::new([Group::EMPTY; GROUPS]), queue: Box::new(Prepared::EMPTY) }
    }
}

/// Sixteen rays under way.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Group {
    rays: Prepared<LANES>,
    node: [u32; LANES],
    /// Place in the stack above which there is nothing.
    top: [u32; LANES],
    /// The words of leaves.
    leaf: [[u32; LANES]; 2],
    hit: [[f32; LANES]; 2],
    primitive: [u32; LANES],
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

impl Group {
    const EMPTY: Self = Self {
        rays: Prepared::EMPTY,
        node: [0; LANES],
        top: [0; LANES],
        leaf: [[0; LANES]; 2],
        hit: [[0.0; LANES]; 2],
        primitive: [NO_HIT; LANES],
        stepping: 0,
        in_leaves: 0,
        stopped: 0,
        stack: [[Entry { node: DONE, near: f32::NEG_INFINITY, far: f32::INFINITY, _pad: 0 }; LANES];
            ROWS],
    };
}

/// What is left of a batch.
struct Waiting<'a> {
    rays: &'a Rays,
    next: usize,
    queue: &'a mut Prepared<{ 2 * LANES }>,
    /// The rays of the queue that are not under way yet.
    from: usize,
    len: usize,
}

/// The nearest hit of the rays of a batch from `first` on, a multiple of sixteen; of `ANY` the first that is found.
///
/// # Safety
/// The CPU has AVX-512 F, BW, DQ, VL, AVX2, and FMA.
#[inline(always)]
pub(super) unsafe fn trace<const ANY: bool>(
    tree: &KdTree,
    rays: &Rays,
    first: usize,
    stream: &mut Stream,
    done: &mut impl FnMut(usize, &Best),
) {
    let Stream { groups, queue } = stream;
    let mut waiting = Waiting { rays, next: first, queue, from: 0, len: 0 };
    // SAFETY: the caller's.
    unsafe {
        loop {
            let (mut stepping, mut others) = (0, 0);
            for group in groups.iter_mut() {
                let under_way = group.stepping | group.in_leaves | group.stopped;
                if LANES as u32 - under_way.count_ones() >= FREE || under_way == 0 {
                    waiting.refill(tree, group, !under_way & 0xffff);
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
            for group in groups.iter_mut() {
                group.visit_leaves::<ANY>(tree, rays, done);
                group.pop(done);
            }
        }
    }
}

impl Waiting<'_> {
    /// Gives rays to free lanes.
    ///
    /// # Safety
    /// As [`trace`].
    #[inline(always)]
    unsafe fn refill(&mut self, tree: &KdTree, group: &mut Group, mut free: u32) {
        while free != 0 {
            if self.from == self.len {
                if self.next >= self.rays.len() {
                    return;
                }
                // SAFETY: the caller's.
                unsafe { self.prepare(tree) };
                continue;
            }
            // The lowest free lanes, as many as there are rays.
            let count = (self.len - self.from) as u32;
            // SAFETY: BMI2 comes with AVX2 in all CPUs with AVX-512.
            let lanes = unsafe { lowest(free, count) };
            // SAFETY: rows of the queue are readable for sixteen lanes from `from` on, those of
            // the group hold sixteen.
            unsafe {
                let to = (&raw mut group.rays).cast::<f32>();
                let queue = (&raw const *self.queue).cast::<f32>();
                for row in 0..Prepared::<LANES>::ROWS {
                    let to = to.add(row * LANES);
                    let from = _mm512_loadu_ps(queue.add(row * 2 * LANES + self.from));
                    let old = _mm512_load_ps(to);
                    _mm512_store_ps(to, _mm512_mask_expand_ps(old, lanes as u16, from));
                }
                let set = lanes as u16;
                put(&mut group.top, set, _mm512_set1_epi32(1));
                put(&mut group.node, set, _mm512_set1_epi32(Node::ROOT as i32));
                put(&mut group.primitive, set, _mm512_set1_epi32(NO_HIT as i32));
            }
            group.stepping |= lanes;
            free &= !lanes;
            self.from += lanes.count_ones() as usize;
        }
    }

    /// Makes the next sixteen rays ready, and keeps those that may meet the tree.
    ///
    /// # Safety
    /// As [`trace`].
    #[inline(always)]
    unsafe fn prepare(&mut self, tree: &KdTree) {
        self.queue.fill(self.rays, self.next, &tree.bounds);
        self.next += LANES;
        let entering = self.queue.entering();
        (self.from, self.len) = (0, entering.count_ones() as usize);
        if entering == 0xffff {
            return;
        }
        // SAFETY: rows hold more than sixteen lanes.
        unsafe {
            let queue = (&raw mut *self.queue).cast::<f32>();
            for row in 0..Prepared::<LANES>::ROWS {
                let row = queue.add(row * 2 * LANES);
                let kept = _mm512_maskz_compress_ps(entering as u16, _mm512_load_ps(row));
                _mm512_store_ps(row, kept);
            }
        }
    }
}

/// The lowest `count` bits of a set.
#[inline(always)]
unsafe fn lowest(set: u32, count: u32) -> u32 {
    // SAFETY: the caller's.
    unsafe { _pdep_u32((1 << count.min(31)) - 1, set) }
}

#[inline(always)]
unsafe fn lane_numbers() -> __m512i {
    // SAFETY: the caller's.
    unsafe { _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15) }
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
            let node = get(&self.node);
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

            let inverse = by_axis(&self.rays.inverse, y, z);
            let falls = _mm512_movepi32_mask(_mm512_castps_si512(inverse));
            // Offsets of leaves, taken for numbers, are subnormal: many times slower on some CPUs.
            let position = _mm512_castsi512_ps(_mm512_maskz_mov_epi32(inner, word0));
            let early = _mm512_fmsub_ps(position, inverse, by_axis(&self.rays.early, y, z));
            let late = _mm512_fmsub_ps(position, inverse, by_axis(&self.rays.late, y, z));
            let bit = |bit: u32| _mm512_set1_epi32(bit as i32);
            let lower_is_empty = _mm512_test_epi32_mask(word1, bit(Node::LOWER_IS_EMPTY));
            let upper_is_empty = _mm512_test_epi32_mask(word1, bit(Node::UPPER_IS_EMPTY));
            let first_is_empty = (lower_is_empty & !falls) | (upper_is_empty & falls);
            let second_is_empty = (lower_is_empty & falls) | (upper_is_empty & !falls);
            let pair = _mm512_srli_epi32::<{ Node::PAIR_SHIFT }>(word1);
            let lower = _mm512_add_epi32(pair, pair);
            let one = _mm512_set1_epi32(1);
            let first = _mm512_mask_add_epi32(lower, falls, lower, one);
            let second = _mm512_xor_si512(first, one);

            let (near, far) = (get_ps(&self.rays.near), get_ps(&self.rays.far));
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
            put_ps(&mut self.rays.far, visit_near, _mm512_min_ps(late, far));
            put_ps(&mut self.rays.near, visit_far & !visit_near, entered);
            let next = _mm512_mask_mov_epi32(second, visit_near, first);
            put(&mut self.node, inner, next);
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
        let mut nodes = [0u32; LANES];
        let mut nears = [0.0f32; LANES];
        // SAFETY: rows have places for all lanes.
        unsafe {
            _mm512_storeu_si512(nodes.as_mut_ptr().cast(), node);
            _mm512_storeu_ps(nears.as_mut_ptr(), near);
        }
        for lane in lanes_of(lanes) {
            let top = self.top[lane] as usize % ROWS;
            self.stack[top][lane] =
                Entry { node: nodes[lane], near: nears[lane], far: self.rays.far[lane], _pad: 0 };
            self.top[lane] = top as u32 + 1;
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

    /// Tests what is in the leaves; rays go on from there.
    ///
    /// # Safety
    /// As [`trace`].
    #[inline(always)]
    unsafe fn visit_leaves<const ANY: bool>(
        &mut self,
        tree: &KdTree,
        rays: &Rays,
        done: &mut impl FnMut(usize, &Best),
    ) {
        // All tests first, so that none waits for the outcome of another.
        let mut tests = [MaybeUninit::<Tested<__m512>>::uninit(); LANES];
        for (lane, to) in lanes_of(self.in_leaves).zip(&mut tests) {
            let chunk = Node::of_words([self.leaf[0][lane], self.leaf[1][lane]]).chunk();
            let line = self.rays.line(lane);
            // SAFETY: the leaf's first chunk is in the arena.
            unsafe {
                let words = tree.arena.words.as_ptr().add(self.leaf[0][lane] as usize);
                let corners = x86::sixteen(words, chunk, line.axes);
                to.write(x86::test(corners, 0, chunk, &line, self.rays.t[lane]));
            }
        }
        for (lane, tested) in lanes_of(self.in_leaves).zip(&tests) {
            let leaf = Node::of_words([self.leaf[0][lane], self.leaf[1][lane]]);
            let chunk = leaf.chunk();
            // SAFETY: as many were written.
            let tested = unsafe { tested.assume_init_ref() };
            if tested.hits == 0 && !chunk.is_followed() {
                continue;
            }
            let index = self.rays.index[lane] as usize;
            let mut best = Best::up_to(self.rays.t[lane]);
            best.primitive = self.primitive[lane];
            let line = self.rays.line(lane);
            let words = &tree.arena.words[leaf.offset()..];
            // SAFETY: the caller's.
            unsafe {
                x86::keep(*tested, 0, words, chunk, &line, &mut best);
                if chunk.is_followed() {
                    let ray = (rays, index);
                    let rest = &words[chunk.end()..];
                    tree.test_rest::<Avx512>(rest, chunk, &line, ray, &mut best);
                }
            }
            if best.t < self.rays.t[lane] || best.primitive != self.primitive[lane] {
                self.rays.t[lane] = best.t;
                self.primitive[lane] = best.primitive;
                (self.hit[0][lane], self.hit[1][lane]) = (best.u, best.v);
                if ANY {
                    done(index, &best);
                    self.in_leaves &= !(1 << lane);
                }
            }
        }
        self.stopped |= self.in_leaves;
        self.in_leaves = 0;
    }

    /// Takes the next entries from the stacks; lanes whose stack is empty are done.
    ///
    /// # Safety
    /// As [`trace`].
    #[inline(always)]
    fn pop(&mut self, done: &mut impl FnMut(usize, &Best)) {
        let mut under_way = 0;
        for lane in lanes_of(self.stopped) {
            let t = self.rays.t[lane];
            let mut top = self.top[lane] as usize % ROWS;
            // At the bottom is an entry that is always taken.
            let entry = loop {
                top = top.saturating_sub(1);
                let entry = self.stack[top][lane];
                let is_behind = entry.near > t;
                if !is_behind {
                    break entry;
                }
            };
            self.top[lane] = top as u32;
            self.node[lane] = entry.node;
            self.rays.near[lane] = entry.near;
            self.rays.far[lane] = smaller(entry.far, t);
            under_way |= u32::from(entry.node != DONE) << lane;
        }
        for lane in lanes_of(self.stopped & !under_way) {
            if self.primitive[lane] != NO_HIT {
                let (u, v) = (self.hit[0][lane], self.hit[1][lane]);
                let best = Best { t: self.rays.t[lane], u, v, primitive: self.primitive[lane] };
                done(self.rays.index[lane] as usize, &best);
            }
        }
        self.stepping |= under_way;
        self.stopped = 0;
    }
}
