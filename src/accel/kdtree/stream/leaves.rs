//! Leaves of several rays at once.
//!
//! Most leaves fill a part of a register only. Those with up to a quarter of its lanes of triangles
//! are tested four at a time, each for its own ray, those with up to half two at a time: the
//! vertices of all of them fill the two registers of which permutations take the corners, as those
//! of one full leaf do. Leaves with more than that are tested by themselves.

#![allow(clippy::needless_range_loop)] // closures around intrinsics would become calls

use std::mem::offset_of;

use super::{Group, UNDER_WAY, Vector, get};
use crate::accel::kdtree::KdTree;
use crate::accel::kdtree::leaf::{Best, triangle_at};
use crate::accel::kdtree::node::{Chunk, Node};
use crate::accel::kdtree::ray::Prepared;
use crate::accel::triangle::lanes::Tested;
use crate::accel::{LANES, Rays};

/// How many leaves of a list are tested together: two registers hold their vertices, and one a
/// corner of all of their triangles, or of half of those of one leaf. The last list's do not fit.
const KINDS: [Option<usize>; 4] = [Some(4), Some(2), Some(1), None];

/// Lanes of all groups that stand before leaves, by how many are tested at once.
#[derive(Debug)]
pub(super) struct Lists {
    /// With room for a register beyond the last.
    lanes: [[u32; UNDER_WAY + LANES]; KINDS.len()],
    lens: [usize; KINDS.len()],
}

impl Lists {
    pub(super) const EMPTY: Self =
        Self { lanes: [[0; UNDER_WAY + LANES]; KINDS.len()], lens: [0; KINDS.len()] };

    /// Lists the lanes of all groups that stand before leaves.
    ///
    /// # Safety
    /// As [`trace`](super::trace).
    #[inline(always)]
    unsafe fn fill<V: Vector<N>, const N: usize>(&mut self, groups: &[Group<N>]) {
        self.lens = [0; KINDS.len()];
        for (g, group) in groups.iter().enumerate() {
            // SAFETY: the caller's; no list gets more lanes than there are, which leaves room for a
            // register.
            unsafe {
                let chunk = V::shift_right(get::<V, N>(&group.leaf[1]), 2);
                let triangles = V::and_words(chunk, V::splat_words(Chunk::TRIANGLES));
                let vertices = V::and_words(chunk, V::splat_words(Chunk::VERTICES));
                let followed = V::and_words(chunk, V::splat_words(Chunk::FOLLOWED));
                let numbers = V::add_words(V::lane_numbers(), V::splat_words((g * N) as u32));
                let mut left = V::set(group.in_leaves);
                let whole = V::equal_words(followed, V::splat_words(0));
                for i in 0..KINDS.len() {
                    let mut set = left;
                    if let Some(m) = KINDS[i] {
                        let most_triangles = if m == 1 { Chunk::MAX_TRIANGLES } else { N / m };
                        let most_vertices = Chunk::vertices_bits((2 * N / m) as u32);
                        let fits = whole
                            & V::at_most(triangles, V::splat_words(most_triangles as u32))
                            & V::at_most(vertices, V::splat_words(most_vertices));
                        set = left & fits;
                        left = left & !fits;
                    }
                    let set = V::bits(set);
                    if KINDS[i].is_some() || set != 0 {
                        let to = self.lanes[i].as_mut_ptr().add(self.lens[i]);
                        V::numbers(numbers).compress(set).store(to.cast());
                        self.lens[i] += set.count_ones() as usize;
                    }
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
pub(super) unsafe fn visit<V: Vector<N>, const N: usize, const GROUPS: usize, const ANY: bool>(
    groups: &mut [Group<N>; GROUPS],
    lists: &mut Lists,
    tree: &KdTree,
    rays: &Rays,
    done: &mut impl FnMut(usize, &Best),
) {
    // SAFETY: the caller's; lists are of leaves of their kinds.
    unsafe {
        lists.fill::<V, N>(groups);
        let Lists { lanes: [four, two, one, more], lens } = lists;
        visit_each::<V, N, GROUPS, 4, ANY>(groups, &four[..lens[0]], tree, done);
        visit_each::<V, N, GROUPS, 2, ANY>(groups, &two[..lens[1]], tree, done);
        visit_each::<V, N, GROUPS, 1, ANY>(groups, &one[..lens[2]], tree, done);
        for &number in &more[..lens[3]] {
            let (g, at) = (number as usize / N % GROUPS, number as usize % N);
            visit_alone::<V, N, ANY>(&mut groups[g], at, tree, rays, done);
        }
    }
    for group in groups {
        group.stopped |= group.in_leaves;
        group.in_leaves = 0;
    }
}

/// Tests leaves, `M` at a time.
///
/// # Safety
/// As [`trace`](super::trace); the lanes stand before leaves of which `M` fit in a register.
#[inline(always)]
unsafe fn visit_each<
    V: Vector<N>,
    const N: usize,
    const GROUPS: usize,
    const M: usize,
    const ANY: bool,
>(
    groups: &mut [Group<N>; GROUPS],
    lanes: &[u32],
    tree: &KdTree,
    done: &mut impl FnMut(usize, &Best),
) {
    for some in lanes.chunks(M) {
        // SAFETY: the caller's.
        unsafe {
            let mut meeting = Meeting::<N, M>::new(groups, some, tree);
            loop {
                let tested = meeting.test::<V>();
                if tested.hits != 0 {
                    meeting.keep::<V, ANY>(tested, groups, done);
                }
                if M > 1 || N == Chunk::MAX_TRIANGLES || !meeting.go_on(groups) {
                    break;
                }
            }
        }
    }
}

/// `M` rays before leaves that fill a register of `N` lanes together. Where there are fewer, the last
/// is taken again, and none of its triangles.
struct Meeting<const N: usize, const M: usize> {
    /// Group and lane.
    at: [[usize; 2]; M],
    /// The first row of each ray.
    rows: [*const f32; M],
    words: [*const u32; M],
    chunks: [Chunk; M],
    axes: [[usize; 3]; M],
    /// The triangle of a single leaf that is in the first lane.
    first: usize,
    /// Lanes of the register that hold triangles.
    present: u32,
}

/// The first row of the ray of a lane.
#[inline(always)]
fn row_of<const N: usize>(group: &Group<N>, lane: usize) -> *const f32 {
    (&raw const group.flights.rays).cast::<f32>().wrapping_add(lane)
}

impl<const N: usize, const M: usize> Meeting<N, M> {
    /// Lanes of the register for each ray.
    const SHARE: usize = N / M;

    /// # Safety
    /// As [`visit_each`]; there is a lane.
    #[inline(always)]
    unsafe fn new<const GROUPS: usize>(
        groups: &[Group<N>; GROUPS],
        lanes: &[u32],
        tree: &KdTree,
    ) -> Self {
        let mut meeting = Self {
            at: [[0; 2]; M],
            rows: [std::ptr::null(); M],
            words: [std::ptr::null(); M],
            chunks: [Chunk::default(); M],
            axes: [[0; 3]; M],
            first: 0,
            present: 0,
        };
        for i in 0..M {
            // SAFETY: leaves have offsets in the arena.
            unsafe {
                let number = *lanes.get_unchecked(i.min(lanes.len() - 1)) as usize;
                let (g, lane) = (number / N % GROUPS, number % N);
                let group = &groups[g];
                meeting.at[i] = [g, lane];
                meeting.rows[i] = row_of(group, lane);
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

    /// Turns to the next triangles of a single leaf; tells whether there are any, for a ray that is
    /// not done.
    #[inline(always)]
    fn go_on(&mut self, groups: &[Group<N>]) -> bool {
        self.first += N;
        self.present >>= N;
        let [g, at] = self.at[0];
        // The ray has been written to since.
        self.rows[0] = row_of(&groups[g], at);
        self.present != 0 && groups[g].in_leaves >> at & 1 == 1
    }

    /// Tests each ray with the triangles of its leaf.
    ///
    /// # Safety
    /// As [`visit_each`].
    #[inline(always)]
    unsafe fn test<V: Vector<N>>(&self) -> Tested<V> {
        let origin = const { offset_of!(Prepared<N>, origin) / (4 * N) };
        let shear = const { offset_of!(Prepared<N>, shear) / (4 * N) };
        // SAFETY: rays have these rows.
        unsafe {
            let origin = [self.row(origin), self.row(origin + 1), self.row(origin + 2)];
            let shear = [self.row(shear), self.row(shear + 1), self.row(shear + 2)];
            let t: V = self.row(const { offset_of!(Prepared<N>, t) / (4 * N) });
            let corners = V::corners(self.words, self.chunks, self.axes, self.first, self.present);
            Tested::without_branch(corners, origin, shear, t, self.present)
        }
    }

    /// A number of each ray, in all of its lanes.
    ///
    /// # Safety
    /// As [`visit_each`]; rays have that row.
    #[inline(always)]
    unsafe fn row<V: Vector<N>>(&self, row: usize) -> V {
        let mut from = self.rows;
        // SAFETY: the caller's.
        unsafe {
            for i in 0..M {
                from[i] = from[i].add(row * N);
            }
            V::shares(from)
        }
    }

    /// Keeps the nearest hit of each ray.
    ///
    /// # Safety
    /// As [`visit_each`].
    #[inline(always)]
    unsafe fn keep<V: Vector<N>, const ANY: bool>(
        &self,
        tested: Tested<V>,
        groups: &mut [Group<N>],
        done: &mut impl FnMut(usize, &Best),
    ) {
        // SAFETY: the caller's; arrays have as many places as a register, and ids stand in the arena.
        unsafe {
            let tested = tested.settle(|lane| {
                let i = lane / Self::SHARE;
                let [g, at] = self.at[i];
                let words = std::slice::from_raw_parts(self.words[i], self.chunks[i].ids_at());
                let triangle = triangle_at(words, self.chunks[i], self.first + lane % Self::SHARE);
                (groups[g].flights.rays.line(at).sheared(), triangle)
            });
            let parts = tested.parts();
            let mut numbers = [[0.0f32; N]; 4];
            tested.t.store(numbers[0].as_mut_ptr());
            for i in 0..3 {
                parts[i].store(numbers[1 + i].as_mut_ptr());
            }
            let t = V::splat(f32::INFINITY).replace(tested.hits, tested.t);
            let mut nearest = tested.hits & t.le(t.least_of_shares::<M>());
            while nearest != 0 {
                // The first of equals has the lowest id.
                let lane = nearest.trailing_zeros() as usize % N;
                let i = lane / Self::SHARE;
                nearest &= u32::MAX << ((i + 1) * Self::SHARE);
                let [g, at] = self.at[i];
                let group = &mut groups[g];
                let nth = self.first + lane % Self::SHARE;
                let id = *self.words[i].add(self.chunks[i].ids_at() + nth);
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

/// Tests all that is in the leaf of a lane.
///
/// # Safety
/// As [`trace`](super::trace).
#[inline(always)]
unsafe fn visit_alone<V: Vector<N>, const N: usize, const ANY: bool>(
    group: &mut Group<N>,
    at: usize,
    tree: &KdTree,
    rays: &Rays,
    done: &mut impl FnMut(usize, &Best),
) {
    let leaf = Node::of_words([group.leaf[0][at], group.leaf[1][at]]);
    let line = group.flights.rays.line(at);
    let ray = (rays, group.flights.rays.index[at] as usize);
    let mut best = group.best(at);
    // SAFETY: the caller's.
    unsafe { tree.test_leaf::<V::Kernel>(leaf, &line, ray, &mut best) };
    let is_new = best.primitive != group.flights.primitive[at];
    group.set_best(at, &best);
    if ANY && is_new {
        group.finish(at, done);
    }
}
