//! Leaves of several rays at once.
//!
//! Most leaves fill only a part of a register. Leaves with up to four triangles are tested together
//! with those of other rays, one in each quad of lanes. Their vertices fill the two registers from
//! which permutations take the corners, as the vertices of one full leaf do.

#![allow(clippy::needless_range_loop)] // closures around intrinsics would become calls

use crate::primitives::triangle::lanes::Tested;
use crate::rays::Rays;
use crate::simd::Lanes;
use crate::structure::kdtree::flight::{Memory, Ray, ShearedLanes, Vector};
use crate::structure::kdtree::leaf::{Chunk, triangle_at};
use crate::structure::kdtree::query::Query;
use crate::structure::kdtree::tree::KdTree;
use crate::structure::kdtree::treelet::{Child, Stop, Stops};

/// Lanes of a quad.
const QUAD: usize = 4;

/// Tests the leaves that fit into quads, `QUADS` at a time, and looks up the next visits of their
/// rays. An incomplete group waits for others, unless it is all there is.
///
/// # Safety
/// As [`trace`](super::trace).
#[inline(always)]
pub(super) unsafe fn visit_quarters<V: Vector, Q: Query, const QUADS: usize, const FAR: bool>(
    memory: &Memory,
    stops: &mut Stops,
) {
    let len = stops.len(Child::QUARTERS);
    if len == 0 {
        return;
    }
    let now = if len < QUADS { len } else { len / QUADS * QUADS };
    stops.take(Child::QUARTERS);
    // SAFETY: stops of this list are leaves of that kind, and rays in flight.
    unsafe {
        for first in (0..now).step_by(QUADS) {
            let count = (now - first).min(QUADS);
            // If there are too few, the last is repeated.
            let mut group = [stops.get(Child::QUARTERS, first); QUADS];
            for i in 1..QUADS {
                group[i] = stops.get(Child::QUARTERS, first + i.min(count - 1));
            }
            test_quarters::<V, Q, QUADS>(memory, &group, count);
            for stop in &group[..count] {
                go_on::<Q, FAR>(memory, stops, stop.place());
            }
        }
        for i in now..len {
            stops.push(stops.get(Child::QUARTERS, i));
        }
    }
}

/// Tests the leaves that need a whole register, and looks up the next visits of their rays.
///
/// # Safety
/// As [`trace`](super::trace).
#[inline(always)]
pub(super) unsafe fn visit_wholes<V: Vector, Q: Query, const FAR: bool>(
    memory: &Memory,
    stops: &mut Stops,
) {
    // SAFETY: stops of this list are leaves of that kind, and rays in flight.
    unsafe {
        for i in 0..stops.take(Child::WHOLES) {
            let stop = stops.get(Child::WHOLES, i);
            let ray = memory.ray(stop.place());
            let words = memory.words.add(stop.child().offset());
            test_chunk::<V, Q>(memory, ray, Chunk(*words), words.add(1));
            go_on::<Q, FAR>(memory, stops, stop.place());
        }
    }
}

/// Looks up the next visit of a ray after a leaf.
///
/// # Safety
/// The ray is in flight, and in no list.
#[inline(always)]
unsafe fn go_on<Q: Query, const FAR: bool>(memory: &Memory, stops: &mut Stops, place: u32) {
    // SAFETY: the caller's.
    unsafe {
        let ray = memory.ray(place);
        let next = memory.pop::<FAR>(ray);
        let next = if Q::ANY && (*ray).is_hit() { Child::DONE } else { next };
        stops.push(Stop::new(place, next));
    }
}

/// Tests all that is in a leaf of any kind.
///
/// # Safety
/// As [`trace`](super::trace).
#[inline(always)]
pub(super) unsafe fn visit_any<V: Vector, Q: Query>(
    memory: &Memory,
    tree: &KdTree,
    rays: &Rays,
    leaf: Child,
    ray: *mut Ray,
) {
    let mut words = &tree.words()[leaf.offset()..];
    loop {
        let chunk = Chunk(words[0]);
        // SAFETY: the caller's.
        unsafe { test_chunk::<V, Q>(memory, ray, chunk, words[1..].as_ptr()) };
        words = &words[1 + chunk.end()..];
        if chunk.has_curved() {
            // SAFETY: the caller's.
            unsafe {
                let mut best = (*ray).best();
                tree.test_curved(words, (rays, (*ray).index), &mut best);
                (*ray).set_best(&best);
                memory.cull::<V>(ray);
            }
            return;
        }
        if !chunk.is_followed() {
            return;
        }
    }
}

/// Tests leaves that fit into quads, each for its ray; the first `count` count.
///
/// # Safety
/// As [`trace`](super::trace).
#[inline(always)]
unsafe fn test_quarters<V: Vector, Q: Query, const QUADS: usize>(
    memory: &Memory,
    group: &[Stop; QUADS],
    count: usize,
) {
    const { assert!(QUADS * QUAD == V::COUNT) };
    let mut rays = [std::ptr::null_mut::<Ray>(); QUADS];
    let mut words = [std::ptr::null(); QUADS];
    let mut chunks = [Chunk::default(); QUADS];
    let mut axes = [[0; 3]; QUADS];
    let mut present = 0;
    let mut rows = [[std::ptr::null(); QUAD]; 3];
    // SAFETY: the caller's; rows have four numbers.
    unsafe {
        for i in 0..QUADS {
            let at = memory.words.add(group[i].child().offset());
            let ray = memory.ray(group[i].place());
            (rays[i], words[i], chunks[i]) = (ray, at.add(1), Chunk(*at));
            axes[i] = (*ray).axes();
            let set = (1 << chunks[i].triangles()) - 1;
            present |= if i < count { set << (i * QUAD) } else { 0 };
            rows[0][i] = (&raw const (*ray).origin).cast();
            rows[1][i] = (&raw const (*ray).shear).cast();
            rows[2][i] = &raw const (*ray).t;
        }
        let (origin, shear) = (V::quads(&rows[0]), V::quads(&rows[1]));
        let origin = [
            origin.splat_in_quads::<0>(),
            origin.splat_in_quads::<0x55>(),
            origin.splat_in_quads::<0xaa>(),
        ];
        let shear = [
            shear.splat_in_quads::<0>(),
            shear.splat_in_quads::<0x55>(),
            shear.splat_in_quads::<0xaa>(),
        ];
        let t_max = V::splat_quads(&rows[2]);
        let corners = V::corners_of_quads(words, chunks, axes, present);
        let tested = Tested::without_branch(corners, origin, shear, t_max, present);
        if tested.hits == 0 {
            return;
        }
        let tested = tested.settle(|lane| {
            let i = lane / QUAD % QUADS;
            let words = std::slice::from_raw_parts(words[i], chunks[i].ids_at());
            ((*rays[i]).line().sheared(), triangle_at(words, chunks[i], lane % QUAD))
        });
        let t = V::splat(f32::INFINITY).replace(tested.hits, tested.t);
        let mut nearest = tested.hits & t.le(t.least_of_quads());
        let hits = Hits::new(&tested);
        while nearest != 0 {
            // The first of equals has the lowest id.
            let lane = nearest.trailing_zeros() as usize;
            let i = lane / QUAD % QUADS;
            nearest &= u32::MAX << (i * QUAD) << QUAD;
            let id = *words[i].add(chunks[i].ids_at() + lane % QUAD);
            hits.offer::<V, Q>(lane, id, rays[i], memory);
        }
    }
}

/// Tests the triangles of a chunk.
///
/// # Safety
/// As [`trace`](super::trace); `words` are those behind the chunk.
#[inline(always)]
unsafe fn test_chunk<V: Vector, Q: Query>(
    memory: &Memory,
    ray: *mut Ray,
    chunk: Chunk,
    words: *const u32,
) {
    // SAFETY: the caller's.
    unsafe {
        let Ray { origin, shear, .. } = &*ray;
        let origin = [V::splat(origin[0]), V::splat(origin[1]), V::splat(origin[2])];
        let shear = [V::splat(shear[0]), V::splat(shear[1]), V::splat(shear[2])];
        let sheared = ShearedLanes { axes: (*ray).axes(), origin, shear };
        let mut first = 0;
        // At least one register, so that there is no branch if one is enough for all chunks.
        loop {
            let left = chunk.triangles() - first;
            let present = (1 << left.min(V::COUNT)) - 1;
            let corners = V::sheared_corners(words, chunk, sheared, first, present);
            let t_max = V::splat((*ray).t);
            let tested = Tested::of_sheared(corners, shear[2], t_max, present);
            if tested.hits != 0 {
                let tested = tested.settle(|lane| {
                    let words = std::slice::from_raw_parts(words, chunk.ids_at());
                    ((*ray).line().sheared(), triangle_at(words, chunk, first + lane))
                });
                let t = V::splat(f32::INFINITY).replace(tested.hits, tested.t);
                let nearest = tested.hits & t.le(t.least());
                if nearest != 0 {
                    // The first of equals has the lowest id.
                    let lane = nearest.trailing_zeros() as usize;
                    let id = *words.add(chunk.ids_at() + first + lane);
                    Hits::new(&tested).offer::<V, Q>(lane, id, ray, memory);
                }
            }
            first += V::COUNT;
            if V::COUNT >= Chunk::MAX_TRIANGLES || first >= chunk.triangles() {
                return;
            }
        }
    }
}

/// Where triangles of a register are hit.
struct Hits {
    t: [f32; 16],
    /// Weights of the second and third corner, and what to divide them by.
    parts: [[f32; 16]; 3],
}

impl Hits {
    /// # Safety
    /// The CPU has the instructions of `L`.
    #[inline(always)]
    unsafe fn new<L: Lanes>(tested: &Tested<L>) -> Self {
        let mut hits = Self { t: [0.0; 16], parts: [[0.0; 16]; 3] };
        let [u, v, sum] = tested.parts();
        // SAFETY: the caller's; there are as many places as lanes, or more.
        unsafe {
            tested.t.store(hits.t.as_mut_ptr());
            u.store(hits.parts[0].as_mut_ptr());
            v.store(hits.parts[1].as_mut_ptr());
            sum.store(hits.parts[2].as_mut_ptr());
        }
        hits
    }

    /// Keeps a hit that is not beyond the ray's best if it is nearer or has a lower id.
    ///
    /// # Safety
    /// The CPU has the instructions of `V`; the ray is in flight.
    #[inline(always)]
    unsafe fn offer<V: Vector, Q: Query>(
        &self,
        lane: usize,
        id: u32,
        ray: *mut Ray,
        memory: &Memory,
    ) {
        let lane = lane % 16;
        let t = self.t[lane];
        // SAFETY: the caller's.
        unsafe {
            if t < (*ray).t || id < (*ray).primitive {
                let sum = self.parts[2][lane];
                ((*ray).t, (*ray).primitive) = (t, id);
                ((*ray).u, (*ray).v) = (self.parts[0][lane] / sum, self.parts[1][lane] / sum);
                if !Q::ANY {
                    memory.cull::<V>(ray);
                }
            }
        }
    }
}
