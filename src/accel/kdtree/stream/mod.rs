//! Rays that have nothing in common, one to a lane, each on its own way down the tree.
//!
//! A step takes a group of rays, as many as a register has lanes, from nodes to one of their
//! children: the nodes, of 8 bytes each, are gathered, so that many loads are under way at once, and
//! next to nothing depends on a branch that the CPU would have to guess. What is left for later goes
//! to stacks, one to a lane. Lanes that reach a leaf wait until enough of them do; their leaves are
//! then fetched together, and tested a register of triangles at once, those of up to four leaves
//! ([`leaves`]).
//!
//! One text serves registers of 16 lanes (AVX-512) and of 8 (AVX2); [`vector`] has what differs.

mod avx2;
mod avx512;
mod leaves;
mod queue;
#[cfg(test)]
mod tests;
mod vector;

use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
use std::mem::offset_of;

use super::leaf::Best;
use super::node::Node;
use super::ray::Prepared;
use super::{KdTree, Left, MAX_DEPTH, NO_HIT, packet};
use crate::accel::simd::lanes_of;
use leaves::Lists;
use queue::{Queue, Waiting};
pub(super) use vector::Vector;

/// Rays under way, of all groups: while one group waits for memory, the others step.
const UNDER_WAY: usize = 32;

/// Rays in nodes go on without those in leaves while there are so many of them.
const ENOUGH: u32 = 18;

/// Below the bottom of each stack.
const DONE: u32 = u32::MAX;

/// Entries of a stack: its bottom, and one for each split on the way. A power of two, so that it is
/// next to nothing to make sure that a place is one of them.
const ROWS: usize = (MAX_DEPTH + 2).next_power_of_two();

/// Working memory of `GROUPS` groups of `N` rays.
#[derive(Debug)]
pub(super) struct Stream<const N: usize, const GROUPS: usize> {
    groups: Box<[Group<N>; GROUPS]>,
    queue: Box<Queue>,
    lists: Lists,
}

impl<const N: usize, const GROUPS: usize> Default for Stream<N, GROUPS> {
    fn default() -> Self {
        const { assert!(N * GROUPS <= UNDER_WAY) };
        Self {
            groups: Box::new([Group::EMPTY; GROUPS]),
            queue: Box::new(Queue::EMPTY),
            lists: Lists::EMPTY,
        }
    }
}

#[cfg(test)]
impl<const N: usize, const GROUPS: usize> Stream<N, GROUPS> {
    /// Whether rays that left packets ever were under way.
    pub(super) fn took_over(&self) -> bool {
        self.queue.has_parked()
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
    const ROWS: usize = offset_of!(Self, primitive) / (4 * N) + 1;

    /// Which of them tells where rays stand: the first behind those of the rays, which may have been
    /// padded.
    const NODE_ROW: usize = offset_of!(Self, node) / (4 * N);

    /// Rays that have met nothing yet.
    #[inline(always)]
    fn start_at_root(&mut self) {
        self.node = [Node::ROOT as u32; N];
        self.top = [1; N];
        self.hit = [[0.0; N]; 2];
        self.primitive = [NO_HIT; N];
    }
}

/// `N` rays under way.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Group<const N: usize> {
    flights: Flights<N>,
    /// The words of leaves.
    leaf: [[u32; N]; 2],
    /// Lanes that stand before nodes, before leaves, and those that are to take what is on their
    /// stack; the others are free.
    stepping: u32,
    in_leaves: u32,
    stopped: u32,
    stack: [[Entry; N]; ROWS],
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

impl<const N: usize> Group<N> {
    const EMPTY: Self = Self {
        flights: Flights::EMPTY,
        leaf: [[0; N]; 2],
        stepping: 0,
        in_leaves: 0,
        stopped: 0,
        stack: [[Entry::BOTTOM; N]; ROWS],
    };

    /// All lanes.
    const ALL: u32 = (1 << N) - 1;
}

/// The nearest hit of rays, of `ANY` the first that is found; with `packets` those that go the same
/// way are traced together as long as that is worth its while.
///
/// # Safety
/// The CPU has the instructions of `V`.
#[inline(always)]
pub(super) unsafe fn trace<V: Vector<N>, const N: usize, const GROUPS: usize, const ANY: bool>(
    tree: &KdTree,
    left: Left,
    packets: Option<&mut packet::Stack>,
    stream: &mut Stream<N, GROUPS>,
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
                let free = !under_way & Group::<N>::ALL;
                waiting.refill::<V, N, ANY>(tree, group, free, done);
                stepping += group.stepping.count_ones();
                others += (group.in_leaves | group.stopped).count_ones();
            }
            if stepping + others == 0 {
                return;
            }
            loop {
                let (mut stepping, mut others) = (0, 0);
                for group in groups.iter_mut() {
                    group.step::<V>(tree);
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
            leaves::visit::<V, N, GROUPS, ANY>(groups, lists, tree, rays, done);
            for group in groups.iter_mut() {
                group.pop::<V>(done);
            }
        }
    }
}

#[inline(always)]
unsafe fn get<V: Vector<N>, const N: usize>(row: &[u32; N]) -> V::Words {
    // SAFETY: the caller's.
    unsafe { V::load_words(row.as_ptr()) }
}

#[inline(always)]
unsafe fn get_ps<V: Vector<N>, const N: usize>(row: &[f32; N]) -> V {
    // SAFETY: the caller's.
    unsafe { V::load(row.as_ptr()) }
}

/// Writes the lanes of a set. All lanes are stored: a load after a masked store would have to wait
/// until the store has reached the cache.
#[inline(always)]
unsafe fn put<V: Vector<N>, const N: usize>(row: &mut [u32; N], set: V::Set, words: V::Words) {
    // SAFETY: the caller's.
    unsafe {
        let all = V::choose_words(set, get::<V, N>(row), words);
        V::store_words(all, row.as_mut_ptr());
    }
}

#[inline(always)]
unsafe fn put_ps<V: Vector<N>, const N: usize>(row: &mut [f32; N], set: V::Set, numbers: V) {
    // SAFETY: the caller's.
    unsafe { V::choose(set, get_ps(row), numbers).store(row.as_mut_ptr()) }
}

/// The row of each lane's axis.
#[inline(always)]
unsafe fn by_axis<V: Vector<N>, const N: usize>(rows: &[[f32; N]; 3], y: V::Set, z: V::Set) -> V {
    // SAFETY: the caller's.
    unsafe {
        let x_or_y = V::choose(y, get_ps(&rows[0]), get_ps(&rows[1]));
        V::choose(z, x_or_y, get_ps(&rows[2]))
    }
}

impl<const N: usize> Group<N> {
    /// Takes the lanes that stand before nodes a step further.
    ///
    /// # Safety
    /// As [`trace`].
    #[inline(always)]
    unsafe fn step<V: Vector<N>>(&mut self, tree: &KdTree) {
        // SAFETY: lanes stand before nodes of the tree; no way has more splits than the stacks
        // have rows.
        unsafe {
            let stepping = V::set(self.stepping);
            let node = get::<V, N>(&self.flights.node);
            let [word0, word1] = V::gather_pairs(tree.nodes.as_ptr().cast(), node, stepping);
            let (y, z) = (V::with_bit(word1, 0), V::with_bit(word1, 1));
            let leaves = stepping & y & z;
            let inner = stepping & !leaves;
            put::<V, N>(&mut self.leaf[0], leaves, word0);
            put::<V, N>(&mut self.leaf[1], leaves, word1);

            let rays = &mut self.flights.rays;
            let inverse: V = by_axis(&rays.inverse, y, z);
            let falls = inverse.is_negative();
            // Offsets of leaves, taken for numbers, are subnormal: many times slower on some CPUs.
            let position = V::choose(inner, V::splat(0.0), V::numbers(word0));
            let early = position.mul_sub(inverse, by_axis(&rays.early, y, z));
            let late = position.mul_sub(inverse, by_axis(&rays.late, y, z));
            let lower_is_empty = V::with_bit(word1, Node::LOWER_IS_EMPTY.trailing_zeros());
            let upper_is_empty = V::with_bit(word1, Node::UPPER_IS_EMPTY.trailing_zeros());
            let first_is_empty = (lower_is_empty & !falls) | (upper_is_empty & falls);
            let second_is_empty = (lower_is_empty & falls) | (upper_is_empty & !falls);
            let pair = V::shift_right(word1, Node::PAIR_SHIFT);
            let lower = V::add_words(pair, pair);
            let first = V::add_one(lower, falls);
            let second = V::xor_words(first, V::splat_words(1));

            let (near, far): (V, V) = (get_ps(&rays.near), get_ps(&rays.far));
            // So written that NaN skips nothing.
            let visit_near = near.not_above(late, inner & !first_is_empty);
            let visit_far = far.not_below(early, inner & !second_is_empty);
            let both = V::bits(visit_near & visit_far);
            let entered = early.max(near);
            if both != 0 {
                self.push::<V>(both, second, entered);
            }
            let rays = &mut self.flights.rays;
            put_ps(&mut rays.far, visit_near, late.min(far));
            put_ps(&mut rays.near, visit_far & !visit_near, entered);
            let next = V::choose_words(visit_near, second, first);
            put::<V, N>(&mut self.flights.node, inner, next);
            self.stepping = V::bits(visit_near | visit_far);
            self.in_leaves |= V::bits(leaves);
            self.stopped |= V::bits(inner) & !self.stepping;
        }
    }

    /// Puts entries on the stacks of some lanes; they end where the lanes' parts of the tree do.
    ///
    /// # Safety
    /// As [`trace`].
    #[inline(always)]
    unsafe fn push<V: Vector<N>>(&mut self, lanes: u32, node: V::Words, near: V) {
        let mut entries = [Entry::BOTTOM; N];
        // SAFETY: rows have places for all lanes, and no stack has more entries than rows.
        unsafe {
            let far = get_ps(&self.flights.rays.far);
            let to = entries.as_mut_ptr().cast::<f32>();
            let rows = V::interleave([V::numbers(node), near, far, far]);
            for (i, row) in rows.into_iter().enumerate() {
                row.store(to.add(i * N));
            }
            for lane in lanes_of(lanes) {
                let top = self.flights.top[lane % N] as usize % ROWS;
                self.stack[top][lane % N] = entries[lane % 4 * (N / 4) + lane % N / 4];
            }
            let top = V::add_one(get::<V, N>(&self.flights.top), V::set(lanes));
            V::store_words(top, self.flights.top.as_mut_ptr());
        }
    }

    /// Asks for the memory of the leaves.
    ///
    /// # Safety
    /// As [`trace`].
    #[inline(always)]
    unsafe fn prefetch_leaves(&self, tree: &KdTree) {
        for lane in lanes_of(self.in_leaves) {
            let words = tree.arena.words.as_ptr().wrapping_add(self.leaf[0][lane % N] as usize);
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
    unsafe fn pop<V: Vector<N>>(&mut self, done: &mut impl FnMut(usize, &Best)) {
        const WORDS: usize = size_of::<Entry>() / 4;
        const NODE: usize = offset_of!(Entry, node) / 4;
        const NEAR: usize = offset_of!(Entry, near) / 4;
        const FAR: usize = offset_of!(Entry, far) / 4;
        // SAFETY: at the bottom of each stack is an entry that is always taken.
        let hits = unsafe {
            let stopped = V::set(self.stopped);
            let top = get::<V, N>(&self.flights.top);
            V::store_words(V::take_one(top, stopped), self.flights.top.as_mut_ptr());
            let row = V::shift_left(V::add_words(top, V::splat_words(u32::MAX)), N.ilog2());
            let place = V::add_words(row, V::lane_numbers());
            let place = V::shift_left(place, WORDS.ilog2());
            let words = self.stack.as_ptr().cast::<u32>();
            let t: V = get_ps(&self.flights.rays.t);
            let near = V::numbers(V::gather(words.add(NEAR), place, stopped));
            let taken = near.not_above(t, stopped);
            let far = V::numbers(V::gather(words.add(FAR), place, taken));
            let node = V::gather(words.add(NODE), place, taken);
            put::<V, N>(&mut self.flights.node, taken, node);
            put_ps(&mut self.flights.rays.near, taken, near);
            put_ps(&mut self.flights.rays.far, taken, far.min(t));
            let done = taken & V::equal_words(node, V::splat_words(DONE));
            let missed =
                V::equal_words(get::<V, N>(&self.flights.primitive), V::splat_words(NO_HIT));
            self.stepping |= V::bits(taken & !done);
            self.stopped &= !V::bits(taken);
            V::bits(done & !missed)
        };
        for lane in lanes_of(hits) {
            done(self.flights.rays.index[lane % N] as usize, &self.best(lane % N));
        }
    }
}
