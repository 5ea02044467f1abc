//! Packets: rays that go the same way, one to a lane, share their way down the tree.
//!
//! A packet's rays have the signs and the largest axis of their directions in common, so that all
//! of them meet the sides of a plane in the same order. Each lane keeps the part of its ray that
//! lies in the cell. Planes are taken one by one, also within a treelet: the branch on which sides
//! are visited is predicted well, so the CPU runs ahead. If few lanes are left, they leave the
//! packet with their part of the stack, and become rays of the stream.
//!
//! Before rays and triangles of a leaf are tested one by one, those triangles are left out that lie
//! beside all rays, as far as these are in the cell ([`View`]).

#![allow(clippy::needless_range_loop)] // closures around intrinsics would become calls

use super::flight::{Flights, Ray, Vector};
use super::leaf::{Best, Chunk, corners_of, triangle_at};
use super::query::Query;
use super::ray::Prepared;
use super::tree::{KdTree, MAX_DEPTH};
use super::treelet::{Child, Stand};
use super::view::{Seen, View};
use crate::primitives::triangle::lanes::Tested;
use crate::primitives::triangle::turned::smaller;
use crate::rays::{LANES, NO_HIT, Rays};
use crate::simd::{Lanes, lanes_of, load3};

/// Most of sixteen lanes that leave a packet, once leaving pays.
const LEAVING: u32 = 4;

/// Leaving pays once packets came to one in `PLANES_A_FEW` planes with `FEW` of sixteen lanes or
/// fewer, after a trial of `TRIAL` planes.
const FEW: u32 = 2;
const PLANES_A_FEW: u32 = 4;
const TRIAL: u32 = 100;

/// Least number of rays that make a packet.
const ENOUGH: u32 = 4;

/// Packets are made while at least this many of sixteen lanes are in use on average.
const LANES_IN_USE: u32 = 5;

/// The same for trees that are far away, where packets wait for memory and a stream does not.
const FAR_LANES_IN_USE: u32 = 12;

/// Least number of triangles of a chunk for which those beside all rays are left out.
const CULLED: usize = 3;

/// What packets share with the stream.
pub(super) struct Surroundings<'a> {
    pub(super) tree: &'a KdTree,
    pub(super) rays: &'a Rays,
    pub(super) stack: &'a mut Stack,
    pub(super) flights: Flights<'a>,
    pub(super) used: Use,
}

/// Counts how well packets used their lanes, so far in this batch.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Use {
    planes: u32,
    lanes: u32,
    /// Number of planes that packets came to with few lanes.
    few: u32,
    /// Whether few lanes leave their packet.
    pub(super) lets_go: bool,
}

impl Use {
    #[inline(always)]
    fn count(&mut self, lanes: u32) {
        self.planes += 1;
        self.lanes += lanes.count_ones();
    }

    /// Whether the lanes at a plane should leave their packet. If lanes are seldom few, the stream
    /// would have too few rays in flight.
    #[inline(always)]
    fn lets_go<L: Lanes>(&mut self, lanes: u32) -> bool {
        let count = lanes.count_ones() * (LANES / L::COUNT) as u32;
        if count > LEAVING {
            return false;
        }
        self.few += u32::from(count <= FEW);
        self.lets_go |= self.few * PLANES_A_FEW > self.planes + TRIAL;
        self.lets_go
    }

    /// Whether packets pay: rays that share packets with few others are faster in a stream.
    pub(super) fn is_good<L: Lanes, const FAR: bool>(self) -> bool {
        let lanes = if FAR { FAR_LANES_IN_USE } else { LANES_IN_USE };
        u64::from(self.lanes) * LANES as u64 >= u64::from(lanes * self.planes) * L::COUNT as u64
    }
}

/// A part of the tree that is visited later, and the spans of rays in it.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Later {
    near: [f32; LANES],
    far: [f32; LANES],
    stand: Stand,
    lanes: u32,
}

/// Working memory.
#[derive(Debug)]
pub(super) struct Stack {
    later: [Later; MAX_DEPTH + 1],
}

impl Default for Stack {
    fn default() -> Self {
        let stand = Stand { at: Child::ROOT, plane: 0 };
        let later = Later { near: [0.0; LANES], far: [0.0; LANES], stand, lanes: 0 };
        Self { later: [later; MAX_DEPTH + 1] }
    }
}

/// Traces the packets among sixteen rays; returns the rays that are in none.
///
/// # Safety
/// The CPU has the instructions of `V`; there is a free place for each ray.
#[inline(always)]
pub(super) unsafe fn trace<V: Vector, Q: Query>(
    around: &mut Surroundings,
    prepared: &Prepared,
    pending: u32,
    query: &mut Q,
) -> u32 {
    let mut left = 0;
    for base in (0..LANES).step_by(V::COUNT) {
        let mut part = pending & (((1 << V::COUNT) - 1) << base);
        while part != 0 {
            let way = prepared.way[part.trailing_zeros() as usize];
            let mut alike = 0;
            for lane in 0..LANES {
                alike |= u32::from(prepared.way[lane] == way) << lane;
            }
            let set = part & alike;
            part &= !set;
            if set.count_ones() < ENOUGH {
                left |= set;
                continue;
            }
            // SAFETY: the caller's.
            unsafe {
                let mut packet = Packet::<V>::new(around.tree, prepared, base, set >> base);
                packet.walk::<Q>(around);
                packet.finish(query);
            }
        }
    }
    left
}

/// A packet on its way.
struct Packet<'a, V> {
    prepared: &'a Prepared,
    /// The packet's first lane in `prepared`.
    base: usize,
    set: u32,
    way: usize,
    axes: [usize; 3],
    inverse: [V; 3],
    early: [V; 3],
    late: [V; 3],
    origin: [V; 3],
    shear: [V; 3],
    /// Best hits, as in [`Best`]; t is minus infinity in lanes for which any hit was enough and
    /// found.
    t: V,
    u: V,
    v: V,
    primitive: V,
    /// Lanes that have a hit.
    found: u32,
    view: View<V>,
}

/// The best hit of a lane.
#[inline(always)]
fn best_of(hits: &[[f32; LANES]; 4], lane: usize) -> Best {
    let [t, u, v] = [hits[0][lane], hits[1][lane], hits[2][lane]];
    Best { t, u, v, primitive: hits[3][lane].to_bits() }
}

/// Changes the best hit of a lane.
#[inline(always)]
fn put_best<Q: Query>(hits: &mut [[f32; LANES]; 4], lane: usize, best: &Best) {
    let t = if Q::ANY && best.is_hit() { f32::NEG_INFINITY } else { best.t };
    [hits[0][lane], hits[1][lane], hits[2][lane]] = [t, best.u, best.v];
    hits[3][lane] = f32::from_bits(best.primitive);
}

impl<'a, V: Vector> Packet<'a, V> {
    /// # Safety
    /// The CPU has the instructions of `V`.
    #[inline(always)]
    unsafe fn new(tree: &KdTree, prepared: &'a Prepared, base: usize, set: u32) -> Self {
        let lane = base + set.trailing_zeros() as usize;
        let axes = prepared.line(lane).axes;
        // SAFETY: `base` leaves enough lanes.
        unsafe {
            let nothing = V::splat(0.0);
            let origin = load3(&prepared.origin, base);
            let shear = load3(&prepared.shear, base);
            Self {
                prepared,
                base,
                set,
                way: prepared.way[lane] as usize,
                axes,
                inverse: load3(&prepared.inverse, base),
                early: load3(&prepared.early, base),
                late: load3(&prepared.late, base),
                origin,
                shear,
                t: V::load(prepared.t.as_ptr().add(base)),
                u: nothing,
                v: nothing,
                primitive: V::splat(f32::from_bits(NO_HIT)),
                found: 0,
                view: View::new(tree, axes, origin, shear, set),
            }
        }
    }

    /// # Safety
    /// As [`trace`].
    #[inline(always)]
    unsafe fn walk<Q: Query>(&mut self, around: &mut Surroundings) {
        // SAFETY: no way down has more planes than the stack has places; rows have places for all
        // lanes; planes and axes of treelets are those that exist.
        unsafe {
            let later = around.stack.later.as_mut_ptr();
            let memory = around.flights.memory;
            let mut depth = 0;
            let Stand { mut at, mut plane } = around.tree.root();
            let mut lanes = self.set;
            let mut near = V::load(self.prepared.near.as_ptr().add(self.base));
            let mut far = V::load(self.prepared.far.as_ptr().add(self.base));
            loop {
                'down: {
                    while at.is_treelet() {
                        if around.used.lets_go::<V>(lanes) {
                            self.part(around, Stand { at, plane }, lanes, [near, far], depth);
                            break 'down;
                        }
                        around.used.count(lanes);
                        let treelet = memory.treelet(at);
                        let axis = treelet.axis(plane);
                        let position = V::splat(*treelet.planes.get_unchecked(plane));
                        let inverse = *self.inverse.get_unchecked(axis);
                        let early = position.mul_sub(inverse, *self.early.get_unchecked(axis));
                        let late = position.mul_sub(inverse, *self.late.get_unchecked(axis));
                        let falls = self.way >> axis & 1;
                        // So written that NaN skips nothing.
                        let mut visit_near = lanes & !late.lt(near);
                        let mut visit_far = lanes & !far.lt(early);
                        visit_near = if treelet.is_empty(plane, falls) { 0 } else { visit_near };
                        visit_far = if treelet.is_empty(plane, 1 - falls) { 0 } else { visit_far };
                        if visit_near != 0 {
                            if visit_far != 0 {
                                let later = &mut *later.add(depth);
                                early.max(near).store(later.near.as_mut_ptr());
                                far.store(later.far.as_mut_ptr());
                                later.stand = treelet.beyond(at, plane, 1 - falls);
                                later.lanes = visit_far;
                                depth += 1;
                            }
                            far = late.min(far);
                            Stand { at, plane } = treelet.beyond(at, plane, falls);
                            lanes = visit_near;
                        } else if visit_far != 0 {
                            near = early.max(near);
                            Stand { at, plane } = treelet.beyond(at, plane, 1 - falls);
                            lanes = visit_far;
                        } else {
                            break 'down;
                        }
                    }
                    self.test_leaf::<Q>(around.tree, around.rays, at, lanes, [near, far]);
                }
                loop {
                    if depth == 0 {
                        return;
                    }
                    depth -= 1;
                    let later = &*later.add(depth);
                    near = V::load(later.near.as_ptr());
                    lanes = later.lanes & self.set & near.le(self.t);
                    if lanes != 0 {
                        far = self.t.min(V::load(later.far.as_ptr()));
                        Stand { at, plane } = later.stand;
                        break;
                    }
                }
            }
        }
    }

    /// Tests all that is in a leaf.
    ///
    /// # Safety
    /// The CPU has the instructions of `V`.
    #[inline(always)]
    unsafe fn test_leaf<Q: Query>(
        &mut self,
        tree: &KdTree,
        rays: &Rays,
        leaf: Child,
        lanes: u32,
        span: [V; 2],
    ) {
        // SAFETY: the caller's.
        let seen = unsafe { self.view.of(lanes, span) };
        let mut words = &tree.words()[leaf.offset()..];
        loop {
            let chunk = Chunk(words[0]);
            // SAFETY: the caller's.
            unsafe { self.test_chunk::<Q>(&words[1..], chunk, lanes, &seen) };
            if !chunk.is_followed() {
                return;
            }
            words = &words[1 + chunk.end()..];
            if chunk.has_curved() {
                // SAFETY: the caller's.
                unsafe { self.test_curved::<Q>(tree, rays, words, lanes) };
                return;
            }
        }
    }

    /// # Safety
    /// The CPU has the instructions of `V`.
    #[inline(always)]
    unsafe fn test_curved<Q: Query>(
        &mut self,
        tree: &KdTree,
        rays: &Rays,
        words: &[u32],
        lanes: u32,
    ) {
        // SAFETY: the caller's.
        unsafe {
            let mut hits = self.hits();
            for lane in lanes_of(lanes) {
                let mut best = best_of(&hits, lane);
                tree.test_curved(words, (rays, self.prepared.index[self.base + lane]), &mut best);
                self.found |= u32::from(best.is_hit()) << lane;
                put_best::<Q>(&mut hits, lane, &best);
            }
            self.load(&hits);
        }
    }

    /// The set of a chunk's triangles that are not beside all rays.
    ///
    /// # Safety
    /// The CPU has the instructions of `V`; the words are those of a finished arena.
    #[inline(always)]
    unsafe fn among(&self, words: &[u32], chunk: Chunk, seen: &Seen) -> u32 {
        let (triangles, vertices) = (chunk.triangles(), chunk.vertices());
        if triangles < CULLED {
            return (1 << triangles) - 1;
        }
        // Vertices beyond the rays, and before them, across the two axes.
        let (mut beyond, mut before) = (0u64, 0u64);
        // SAFETY: a finished arena goes on for 64 words after the last chunk.
        unsafe {
            let rows = words.as_ptr().cast::<f32>();
            let mut base = 0;
            while base < vertices {
                // What follows the vertices, taken for numbers, is subnormal: many times slower on
                // some CPUs.
                let beyond_last = !((1u32 << (vertices - base).min(V::COUNT)) - 1);
                let zero = V::splat(0.0);
                let z = V::load(rows.add(self.axes[2] * vertices + base));
                let z = z.replace(beyond_last, zero);
                for k in 0..2 {
                    let x = V::load(rows.add(self.axes[k] * vertices + base));
                    let x = x.replace(beyond_last, zero);
                    let x = self.view.shear[k].neg_mul_add(z, x);
                    let shift = 32 * k + base;
                    beyond |= u64::from(V::splat(seen.most[k]).lt(x)) << shift;
                    before |= u64::from(x.lt(V::splat(seen.least[k]))) << shift;
                }
                base += V::COUNT;
            }
        }
        let mut set = 0;
        for i in 0..triangles {
            let [a, b, c] = corners_of(words, chunk, i);
            let all = |sides: u64| (sides >> a) & (sides >> b) & (sides >> c);
            let beside = (all(beyond) | all(before)) & (1 | 1 << 32) != 0;
            set |= u32::from(!beside) << i;
        }
        set
    }

    /// # Safety
    /// The CPU has the instructions of `V`; the words are those of a finished arena.
    #[inline(always)]
    unsafe fn test_chunk<Q: Query>(
        &mut self,
        words: &[u32],
        chunk: Chunk,
        lanes: u32,
        seen: &Seen,
    ) {
        let vertices = chunk.vertices();
        // SAFETY: the caller's.
        unsafe {
            for i in lanes_of(self.among(words, chunk, seen)) {
                let places = corners_of(words, chunk, i);
                let mut corners = [[self.u; 3]; 3];
                for c in 0..3 {
                    for k in 0..3 {
                        let at = self.axes[k] * vertices + places[c];
                        corners[c][k] = V::splat(f32::from_bits(*words.get_unchecked(at)));
                    }
                }
                let tested = Tested::new(corners, self.origin, self.shear, self.t, lanes);
                if tested.hits == 0 {
                    continue;
                }
                let tested = tested.settle(|lane| {
                    let line = self.prepared.line(self.base + lane);
                    (line.sheared(), triangle_at(words, chunk, i))
                });
                self.keep::<Q>(&tested, words[chunk.ids_at() + i]);
            }
        }
    }

    /// Keeps hits that are nearer than the best, or as near and of lower id.
    ///
    /// # Safety
    /// The CPU has the instructions of `V`.
    #[inline(always)]
    unsafe fn keep<Q: Query>(&mut self, tested: &Tested<V>, id: u32) {
        // SAFETY: the caller's; there are as many values as lanes, or more.
        unsafe {
            let mut better = tested.hits & tested.t.lt(self.t);
            let equal = tested.hits & !better;
            if equal != 0 {
                let mut ids = [0.0f32; LANES];
                self.primitive.store(ids.as_mut_ptr());
                for lane in lanes_of(equal) {
                    better |= u32::from(id < ids[lane].to_bits()) << lane;
                }
            }
            self.found |= better;
            self.primitive = self.primitive.replace(better, V::splat(f32::from_bits(id)));
            if Q::ANY {
                self.t = self.t.replace(better, V::splat(f32::NEG_INFINITY));
            } else {
                let [u, v] = tested.weights();
                self.t = self.t.replace(better, tested.t);
                self.u = self.u.replace(better, u);
                self.v = self.v.replace(better, v);
            }
        }
    }

    /// Best hits of all lanes.
    ///
    /// # Safety
    /// The CPU has the instructions of `V`.
    #[inline(always)]
    unsafe fn hits(&self) -> [[f32; LANES]; 4] {
        let mut hits = [[0.0; LANES]; 4];
        // SAFETY: there are as many values as lanes, or more.
        unsafe {
            self.t.store(hits[0].as_mut_ptr());
            self.u.store(hits[1].as_mut_ptr());
            self.v.store(hits[2].as_mut_ptr());
            self.primitive.store(hits[3].as_mut_ptr());
        }
        hits
    }

    /// Takes lanes out of the packet and puts each into flight, with its part of the stack.
    ///
    /// # Safety
    /// As [`trace`]; the lanes stand there, with `depth` entries on the stack.
    #[inline(always)]
    unsafe fn part(
        &mut self,
        around: &mut Surroundings,
        stand: Stand,
        lanes: u32,
        span: [V; 2],
        depth: usize,
    ) {
        self.set &= !lanes;
        let memory = around.flights.memory;
        let mut spans = [[0.0; LANES]; 2];
        // SAFETY: the caller's; there are as many values as lanes, or more.
        unsafe {
            span[0].store(spans[0].as_mut_ptr());
            span[1].store(spans[1].as_mut_ptr());
            let hits = self.hits();
            for lane in lanes_of(lanes) {
                let mut ray = Ray::new(self.prepared, self.base + lane);
                ray.set_best(&best_of(&hits, lane));
                let t = ray.t;
                let ray = around.flights.park(&ray);
                for later in &around.stack.later[..depth] {
                    let span = [later.near[lane], smaller(t, later.far[lane])];
                    if later.lanes >> lane & 1 == 1 && span[0] <= t {
                        memory.push::<V>(ray, later.stand, span);
                    }
                }
                memory.push::<V>(ray, stand, [spans[0][lane], spans[1][lane]]);
            }
        }
    }

    /// # Safety
    /// The CPU has the instructions of `V`.
    #[inline(always)]
    unsafe fn load(&mut self, hits: &[[f32; LANES]; 4]) {
        // SAFETY: there are as many values as lanes, or more.
        unsafe {
            self.t = V::load(hits[0].as_ptr());
            self.u = V::load(hits[1].as_ptr());
            self.v = V::load(hits[2].as_ptr());
            self.primitive = V::load(hits[3].as_ptr());
        }
    }

    /// # Safety
    /// The CPU has the instructions of `V`.
    #[inline(always)]
    unsafe fn finish<Q: Query>(&self, query: &mut Q) {
        let hits = [self.t, self.u, self.v, self.primitive];
        // SAFETY: the rays are those of the batch.
        unsafe { query.accept_lanes(self.prepared, self.base, self.found & self.set, hits) };
    }
}
