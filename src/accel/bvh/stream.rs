//! Many rays in flight at once, a step of each in turn.
//!
//! One ray alone waits for memory at every node, and for the outcome of every branch. Here a step
//! of a ray has next to no branches, ends by asking for the memory that the ray's next step needs,
//! and is followed by steps of other rays. Rays that stand before a node and rays that stand before
//! a leaf are kept in lists, worked off in turn.

use super::Bvh;
use super::binary::BLOCK;
use super::layout::{Child, Corners, Node, WIDTH};
use super::order::{Order, Sixteen};
use super::packet::{self, Surroundings, UseOfLanes};
use super::ray::{Prepared, Ray};
use super::steps::{BlockHits, Steps};
use crate::accel::simd::SetLanes;
use crate::accel::{Coherence, LANES, Rays};

/// Rays in flight.
const IN_FLIGHT: usize = 32;

/// What is asked of a ray.
pub(super) trait Query {
    /// Whether the first hit will do.
    const ANY: bool;
    /// Takes the hit of a ray that is done: its place in the batch; t, u, v; and the id.
    fn accept(&mut self, index: usize, hit: [f32; 3], primitive: u32);
    /// Takes the hits of a set of rays, from the n-th lane of those made ready on: t, u, v, and
    /// bits of ids.
    ///
    /// # Safety
    /// The CPU has the instructions of `L`; the rays are those of this batch.
    unsafe fn accept_lanes<L: SetLanes>(
        &mut self,
        rays: &Prepared,
        base: usize,
        set: u32,
        hits: [L; 4],
    );
    /// Takes a ray that is done.
    #[inline(always)]
    fn finish(&mut self, ray: &Ray) {
        if ray.is_hit {
            self.accept(ray.index as usize, [ray.t, ray.u, ray.v], ray.primitive);
        }
    }
}

/// Working memory of [`trace`].
#[derive(Debug)]
pub(super) struct Stream {
    prepared: Prepared,
    packets: packet::Stack,
    order: Order,
    /// For each place the ray itself, then its stack: distances, then what to visit.
    lines: Vec<Line>,
    free: Vec<u32>,
    parked: Vec<Stop>,
    lists: [[Stop; IN_FLIGHT]; 4],
}

#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Line([u8; 64]);

/// A ray in flight and what it stands before.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(8))]
pub(super) struct Stop {
    /// Where it is.
    place: u32,
    child: Child,
}

impl Default for Stream {
    fn default() -> Self {
        let stop = Stop { place: 0, child: Child::DONE };
        Self {
            prepared: Prepared::EMPTY,
            packets: packet::Stack::default(),
            order: Order::default(),
            lines: vec![],
            free: vec![],
            parked: vec![],
            lists: [[stop; IN_FLIGHT]; 4],
        }
    }
}

/// Entries of the deepest stack, with room for one step's writing beyond it: a ray leaves at most
/// `WIDTH - 1` entries on each level, besides the first.
pub(super) fn stack_size(depth: usize) -> usize {
    1 + depth * (WIDTH - 1) + WIDTH
}

/// The places for rays in flight, each with a stack behind it.
pub(super) struct Flights<'a> {
    first: *mut Line,
    /// From one place to the next, in lines.
    lines: usize,
    memory: Memory,
    free: &'a mut Vec<u32>,
    /// Rays that left a packet and are not in a list yet.
    parked: &'a mut Vec<Stop>,
}

impl Flights<'_> {
    /// Puts a ray into a free place, with an empty stack.
    ///
    /// # Safety
    /// A place is free.
    #[inline(always)]
    unsafe fn put(&mut self, ray: Ray) -> u32 {
        // SAFETY: places lie within the lines, and have room for a ray and its stack.
        unsafe {
            let place = self.free.pop().unwrap_unchecked();
            let home = self.ray(place);
            *home = ray;
            let first = home.add(1).cast::<f32>();
            *first = f32::NEG_INFINITY;
            *first.add(self.memory.stack).cast() = Child::DONE;
            (*home).top = first.add(1);
            place
        }
    }

    /// Puts a ray into a free place, to go into flight before `child` when there is room.
    ///
    /// # Safety
    /// A place is free.
    #[inline(always)]
    pub(super) unsafe fn park(&mut self, ray: Ray, child: Child) -> *mut Ray {
        // SAFETY: the caller's.
        unsafe {
            let place = self.put(ray);
            self.parked.push(Stop { place, child });
            self.ray(place)
        }
    }

    /// # Safety
    /// `place` is one of the places.
    #[inline(always)]
    unsafe fn ray(&self, place: u32) -> *mut Ray {
        // SAFETY: the caller's.
        unsafe { self.first.add(place as usize * self.lines).cast() }
    }
}

/// The rays of a batch that are still to be traced, made ready sixteen at a time.
struct Pending<'a> {
    around: Surroundings<'a>,
    prepared: &'a mut Prepared,
    /// Whether rays that go the same way are traced together.
    packets: bool,
    order: &'a Order,
    /// The sixteen that is made ready next.
    next: usize,
    /// Which of the sixteen are to go into flight.
    left: u32,
}

impl Pending<'_> {
    /// Puts the next ray into flight, if any is left; where it stands.
    ///
    /// # Safety
    /// As [`trace`]; fewer than [`IN_FLIGHT`] rays are in flight.
    #[inline(always)]
    unsafe fn start<S: Steps, Q: Query>(&mut self, query: &mut Q) -> Option<Stop> {
        loop {
            if let Some(stop) = self.around.flights.parked.pop() {
                return Some(stop);
            }
            if self.left != 0 {
                break;
            }
            let (sixteen, count) = self.order.get(self.next)?;
            self.next += 1;
            // SAFETY: the caller's.
            unsafe { self.prepare::<S, Q>(sixteen, count, query) };
        }
        let lane = self.left.trailing_zeros() as usize;
        self.left &= self.left - 1;
        // SAFETY: no ray is parked, and there are more places than rays in flight.
        let place = unsafe { self.around.flights.put(Ray::new(self.prepared, lane)) };
        Some(Stop { place, child: Child::node(0) })
    }

    /// Makes sixteen rays ready, and traces those that can't go into flight, or go in packets.
    ///
    /// # Safety
    /// As [`trace`].
    #[inline(always)]
    unsafe fn prepare<S: Steps, Q: Query>(
        &mut self,
        sixteen: Sixteen,
        count: usize,
        query: &mut Q,
    ) {
        let Surroundings { bvh, rays, .. } = self.around;
        match sixteen {
            Sixteen::Neighbours(first) => self.prepared.fill(rays, first),
            // SAFETY: the caller's.
            Sixteen::Chosen(indices) => unsafe { self.prepared.choose::<S>(rays, indices) },
        }
        let (mut has_length, mut tame) = (0u32, 0u32);
        for lane in 0..LANES {
            has_length |= u32::from(self.prepared.t_max[lane] > 0.0) << lane;
            tame |= self.prepared.is_tame[lane] << lane;
        }
        has_length &= u32::MAX >> (32 - count);
        tame = if bvh.is_tame { has_length & tame } else { 0 };
        let mut wild = has_length & !tame;
        while wild != 0 {
            let lane = wild.trailing_zeros() as usize;
            wild &= wild - 1;
            let ray = Ray::new(self.prepared, lane);
            query.finish(&super::careful::trace(bvh, rays, ray, Q::ANY));
        }
        self.left = if self.packets && self.around.use_of_lanes.is_good() {
            // SAFETY: the caller's.
            unsafe { S::packets(&mut self.around, self.prepared, tame, query) }
        } else {
            tame
        };
    }
}

/// Traces the rays of a batch.
///
/// # Safety
/// The CPU has the instruction set of `S`.
#[inline(always)]
pub(super) unsafe fn trace<S: Steps, Q: Query>(
    bvh: &Bvh,
    rays: &Rays,
    coherence: Coherence,
    query: &mut Q,
    stream: &mut Stream,
) {
    const { assert!(size_of::<Ray>() == 128) };
    // An odd number of lines, so that stacks do not compete for the same places of a cache.
    let lines = (2 + bvh.stack.div_ceil(8)) | 1;
    let Stream { prepared, packets: stack, order, lines: room, free, parked, lists } = stream;
    const PLACES: usize = IN_FLIGHT + LANES;
    room.resize(room.len().max(PLACES * lines), Line([0; 64]));
    free.clear();
    free.extend((0..PLACES as u32).rev());
    parked.clear();
    stack.prepare(bvh.stack);
    let memory =
        Memory { nodes: bvh.nodes.as_ptr(), rows: bvh.corners.rows().as_ptr(), stack: bvh.stack };
    let flights = Flights { first: room.as_mut_ptr(), lines, memory, free, parked };
    let packets = coherence == Coherence::Coherent;
    if packets {
        // SAFETY: the caller's.
        unsafe { order.sort::<S>(rays) }
    } else {
        order.keep(rays)
    }
    let use_of_lanes = UseOfLanes::default();
    let around = Surroundings { bvh, rays, memory, stack, flights, use_of_lanes };
    let mut pending = Pending { around, prepared, packets, order, next: 0, left: 0 };
    let [first, second, leaves, others] = lists;
    let mut nodes = List::new(first);
    let mut stops =
        Stops { nodes: List::new(second), leaves: List::new(leaves), others: List::new(others) };
    // SAFETY:
    // Lists: a ray stands in one list only, and there are as many rays as a list has places.
    // Stacks: there is room for `bvh.stack` entries behind each ray.
    // Nodes and blocks: children of a node are numbers of nodes and blocks that exist.
    unsafe {
        for _ in 0..IN_FLIGHT {
            let Some(stop) = pending.start::<S, Q>(query) else { break };
            stops.push(stop.place, stop.child);
        }
        std::mem::swap(&mut nodes, &mut stops.nodes);
        loop {
            for i in 0..nodes.len {
                let Stop { place, child } = nodes.get(i);
                let ray = &mut *pending.around.flights.ray(place);
                let node = &*memory.nodes.add(child.0 as usize);
                memory.push_children::<S>(node, ray, u8::MAX);
                stops.push(place, memory.pop(ray));
            }
            for i in 0..stops.leaves.take() {
                let Stop { place, child } = stops.leaves.get(i);
                let ray = &mut *pending.around.flights.ray(place);
                let t = ray.t;
                let is_done = test_leaf::<S, Q>(bvh, &memory, child, ray);
                if ray.t < t {
                    memory.cull::<S>(ray);
                }
                let next = if is_done { Child::DONE } else { memory.pop(ray) };
                stops.push(place, next);
            }
            for i in 0..stops.others.take() {
                let Stop { place, child } = stops.others.get(i);
                let ray = &mut *pending.around.flights.ray(place);
                if child != Child::DONE {
                    bvh.test_curved(rays, child, ray);
                    memory.cull::<S>(ray);
                    if !(Q::ANY && ray.is_hit) {
                        stops.push(place, memory.pop(ray));
                        continue;
                    }
                }
                query.finish(ray);
                pending.around.flights.free.push(place);
                if let Some(stop) = pending.start::<S, Q>(query) {
                    stops.push(stop.place, stop.child);
                }
            }
            std::mem::swap(&mut nodes, &mut stops.nodes);
            stops.nodes.len = 0;
            if nodes.len + stops.leaves.len + stops.others.len == 0 {
                break;
            }
        }
    }
}

/// Stops of a kind.
struct List {
    stops: *mut Stop,
    len: usize,
}

impl List {
    fn new(stops: &mut [Stop; IN_FLIGHT]) -> Self {
        Self { stops: stops.as_mut_ptr(), len: 0 }
    }

    /// Empties the list; how long it was. What it held can be read until others are pushed over
    /// it, which happens no sooner than it was read.
    #[inline(always)]
    fn take(&mut self) -> usize {
        std::mem::take(&mut self.len)
    }

    /// # Safety
    /// `i` is less than the length is or was.
    #[inline(always)]
    unsafe fn get(&self, i: usize) -> Stop {
        // SAFETY: the caller's.
        unsafe { *self.stops.add(i) }
    }

    /// Writes behind the list, and makes that its end if asked.
    ///
    /// # Safety
    /// The list is not full.
    #[inline(always)]
    unsafe fn push(&mut self, stop: Stop, keep: bool) {
        // SAFETY: the caller's.
        unsafe { *self.stops.add(self.len) = stop };
        self.len += usize::from(keep);
    }
}

/// Where rays stand next, by kind.
struct Stops {
    nodes: List,
    /// Blocks of triangles.
    leaves: List,
    /// Curved surfaces, and the end.
    others: List,
}

impl Stops {
    /// Puts a ray into the list that is right for its next stop, without a branch.
    ///
    /// # Safety
    /// No list is full.
    #[inline(always)]
    unsafe fn push(&mut self, place: u32, child: Child) {
        let stop = Stop { place, child };
        // SAFETY: the caller's.
        unsafe {
            self.nodes.push(stop, !child.is_leaf());
            self.leaves.push(stop, child.is_block());
            self.others.push(stop, child.is_other());
        }
    }
}

/// The hierarchy as the inner loops see it.
#[derive(Clone, Copy)]
pub(super) struct Memory {
    pub(super) nodes: *const Node,
    pub(super) rows: *const f32,
    /// From a distance on a stack to what to visit there, in entries.
    stack: usize,
}

impl Memory {
    /// Puts those of a node's children that a ray enters on its stack; of them those in `among`,
    /// bit `s` for the child that lies `s`-th from the far end.
    ///
    /// # Safety
    /// There is room for eight entries; the CPU has the instruction set.
    #[inline(always)]
    pub(super) unsafe fn push_children<S: Steps>(&self, node: &Node, ray: &mut Ray, among: u8) {
        // SAFETY: the caller's.
        unsafe {
            let count = S::children(node, ray, among, ray.top, ray.top.add(self.stack).cast());
            ray.top = ray.top.add(count);
        }
    }

    /// Takes the last entry from a ray's stack, and asks for its memory.
    ///
    /// # Safety
    /// The ray's stack holds its first entry at least.
    #[inline(always)]
    unsafe fn pop(&self, ray: &mut Ray) -> Child {
        // SAFETY: the caller's.
        let child = unsafe {
            ray.top = ray.top.sub(1);
            *ray.top.add(self.stack).cast::<Child>()
        };
        self.prefetch(child);
        child
    }

    /// Drops the entries of a ray's stack that begin behind its best hit: done at once when it is
    /// found, so that taking an entry needs no loop whose end the CPU would have to guess.
    ///
    /// # Safety
    /// The CPU has the instruction set; the ray's stack is the one behind it.
    #[inline(always)]
    unsafe fn cull<S: Steps>(&self, ray: &mut Ray) {
        // SAFETY: the caller's; a step's eight entries fit behind the last.
        unsafe {
            let first = (&raw mut *ray).add(1).cast::<f32>();
            let len = ray.top.offset_from_unsigned(first);
            ray.top = first.add(S::cull(first, first.add(self.stack).cast(), len, ray.t));
        }
    }

    /// Asks for the memory of a node or a block.
    #[inline(always)]
    pub(super) fn prefetch(&self, child: Child) {
        #[cfg(target_arch = "x86_64")]
        {
            use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
            let node = self.nodes.wrapping_add(child.0 as usize).cast::<i8>();
            let block = self.rows.wrapping_add(child.index() * Corners::PER_TRIANGLE).cast::<i8>();
            let at = if child.is_leaf() { block } else { node };
            for line in 0..4 {
                // SAFETY: a prefetch reads nothing.
                unsafe { _mm_prefetch::<_MM_HINT_T0>(at.wrapping_add(64 * line)) };
            }
        }
        #[cfg(not(target_arch = "x86_64"))]
        let _ = child;
    }
}

/// Tests a block of triangles; whether the ray is done.
///
/// # Safety
/// The CPU has the instruction set; `child` is a block.
#[inline(always)]
unsafe fn test_leaf<S: Steps, Q: Query>(
    bvh: &Bvh,
    memory: &Memory,
    child: Child,
    ray: &mut Ray,
) -> bool {
    let (first, count) = (child.index(), child.block_len());
    // SAFETY: the caller's; slots of a block have ids.
    unsafe {
        let block = memory.rows.add(first * Corners::PER_TRIANGLE);
        if Q::ANY {
            ray.is_hit = S::any_triangle(block, count, ray);
            return ray.is_hit;
        }
        let mut hits = BlockHits::default();
        let mut set = S::triangles(block, count, ray, &mut hits);
        while set != 0 {
            let lane = set.trailing_zeros() as usize & (BLOCK - 1);
            let id = *bvh.ids.get_unchecked(first + lane);
            ray.offer(hits.t[lane], hits.u[lane], hits.v[lane], id);
            set &= set - 1;
        }
    }
    false
}
