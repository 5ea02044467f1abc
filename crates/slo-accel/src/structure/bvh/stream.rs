//! Streams: many rays in flight, a step of each in turn.
//!
//! A single ray waits for memory at every node, and for the outcome of every branch. Here a step of
//! a ray has next to no branches, ends by prefetching the memory of the ray's next step, and is
//! followed by steps of other rays. Rays that visit a node next and rays that visit a leaf next are
//! kept in lists, which take turns.

use super::flights::{Flights, Line, Memory, RAY_LINES};
use super::hierarchy::Bvh;
use super::layout::{BLOCK, Child, Stop, Stops, id_at};
use super::packet::{self, Packets, RaysPerChild, Surroundings};
use super::query::Query;
use super::ray::{Prepared, Ray};
use super::steps::{BlockHits, MOST_BLOCKS, Meeting, Steps};
use crate::rays::{Coherence, LANES, Rays};
use crate::simd::lanes_of;
use crate::structure::shared::order::{Order, Sixteen};
use crate::structure::shared::stops::{IN_FLIGHT, Lists};

/// Working memory of [`trace`].
#[derive(Debug)]
pub(super) struct Stream {
    prepared: Prepared,
    /// Sixteen rays.
    ready: [Line; LANES * RAY_LINES],
    packets: packet::Stack,
    order: Order,
    /// For each place the ray itself, then its stack: distances, then children.
    lines: Vec<Line>,
    free: Vec<u32>,
    parked: Vec<Stop>,
    lists: Lists<Child>,
}

/// Steps at far nodes before the next visits of their rays are looked up.
const FAR_TURN: usize = 8;

impl Default for Stream {
    fn default() -> Self {
        Self {
            prepared: Prepared::EMPTY,
            ready: [Line([0; 64]); LANES * RAY_LINES],
            packets: packet::Stack::default(),
            order: Order::default(),
            lines: vec![],
            free: vec![],
            parked: vec![],
            lists: [[Stop::NONE; IN_FLIGHT]; 4],
        }
    }
}

/// The rays of a batch that remain to be traced, prepared sixteen at a time.
struct Pending<'a> {
    around: Surroundings<'a>,
    prepared: &'a mut Prepared,
    /// The same rays one by one, if any are left.
    ready: &'a mut [Ray; LANES],
    /// Whether rays that go the same way are traced together.
    packets: bool,
    order: &'a Order,
    /// Number of the sixteen that is prepared next.
    next: usize,
    /// The set of the sixteen that remain to be put into flight.
    left: u32,
}

impl Pending<'_> {
    /// Puts the next ray into flight, and returns its stop; none if no ray is left.
    ///
    /// # Safety
    /// As [`trace`]; fewer than [`IN_FLIGHT`] rays are in flight.
    #[inline(always)]
    unsafe fn start<S: Packets, Q: Query>(&mut self, query: &mut Q) -> Option<Stop> {
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
        let place = unsafe { self.around.flights.put(&self.ready[lane % LANES]) };
        Some(Stop::new(place, Child::node(0)))
    }

    /// Prepares sixteen rays. Traces those that cannot be put into flight, and those that go in
    /// packets.
    ///
    /// # Safety
    /// As [`trace`].
    #[inline(always)]
    unsafe fn prepare<S: Packets, Q: Query>(
        &mut self,
        sixteen: Sixteen,
        count: usize,
        query: &mut Q,
    ) {
        let Surroundings { bvh, rays, times, .. } = self.around;
        match sixteen {
            Sixteen::Neighbours(first) => self.prepared.fill(rays, first),
            Sixteen::Chosen(indices, numbers) => self.prepared.choose(indices, numbers),
        }
        if S::MOVES {
            self.prepared.set_times(times);
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
            query.finish(&super::careful::trace(bvh, rays, ray, Q::ANY, &mut ()));
        }
        self.left = if self.packets && self.around.rays_per_child.is_good() {
            // SAFETY: the caller's.
            unsafe { S::packets(&mut self.around, self.prepared, tame, query) }
        } else {
            tame
        };
        if self.left != 0 {
            // SAFETY: the caller's.
            unsafe { S::deal(self.prepared, self.ready) };
        }
    }
}

/// Traces the rays of a batch; returns how alike they turned out to be. If triangles move, there is
/// a time for each ray.
///
/// # Safety
/// The CPU has the instruction set of `S`, which moves if the hierarchy does.
#[inline(always)]
pub(super) unsafe fn trace<S: Packets, Q: Query>(
    bvh: &Bvh,
    (rays, times): (&Rays, &[f32]),
    coherence: Coherence,
    query: &mut Q,
    stream: &mut Stream,
) -> Coherence {
    const { assert!(size_of::<Ray>() == RAY_LINES * size_of::<Line>()) };
    // An odd number of lines, so that stacks do not compete for the same places of a cache.
    let lines = (RAY_LINES + bvh.stack.div_ceil(8)) | 1;
    let Stream { prepared, ready, packets: stack, order, lines: room, free, parked, lists } =
        stream;
    const PLACES: usize = IN_FLIGHT + LANES;
    room.resize(room.len().max(PLACES * lines), Line([0; 64]));
    free.clear();
    let place = |i: usize| (i * lines * size_of::<Line>()) as u32;
    free.extend((0..PLACES).rev().map(place));
    parked.clear();
    stack.prepare(bvh.stack);
    let memory =
        Memory { nodes: bvh.nodes.as_ptr(), rows: bvh.corners.rows().as_ptr(), stack: bvh.stack };
    let flights = Flights { first: room.as_mut_ptr(), memory, free, parked };
    let packets = coherence == Coherence::Coherent;
    if packets {
        // SAFETY: the caller's.
        unsafe { order.sort::<S::Choosing>(rays) }
    } else {
        order.keep(rays)
    }
    let rays_per_child = RaysPerChild::new(bvh.bytes());
    let around = Surroundings { bvh, rays, times, memory, stack, flights, rays_per_child };
    // SAFETY: any bits are a ray; lines are aligned as rays are, and as long as sixteen.
    let ready = unsafe { &mut *ready.as_mut_ptr().cast::<[Ray; LANES]>() };
    let mut pending = Pending { around, prepared, ready, packets, order, next: 0, left: 0 };
    let mut stops = Stops::new(lists);
    // SAFETY:
    // Lists: a ray stands in one list only, and there are as many rays as a list has places.
    // Stacks: there is room for `bvh.stack` entries behind each ray.
    // Nodes and blocks: children of a node are numbers of nodes and blocks that exist.
    unsafe {
        for _ in 0..IN_FLIGHT {
            let Some(stop) = pending.start::<S, Q>(query) else { break };
            stops.push(stop);
        }
        while !stops.are_none() {
            test_nodes::<S>(&memory, &pending.around.flights, &mut stops);
            test_blocks::<S, Q>(&memory, &pending.around.flights, &mut stops);
            for i in 0..stops.take(Stops::OTHERS) {
                let stop = stops.get(Stops::OTHERS, i);
                let (place, child) = (stop.place(), stop.child());
                let ray = &mut *pending.around.flights.ray(place);
                if child != Child::DONE {
                    bvh.test_curved(rays, child, ray);
                    memory.cull::<S>(ray);
                    if !(Q::ANY && ray.is_hit != 0) {
                        stops.push(Stop::new(place, memory.pop::<S>(ray)));
                        continue;
                    }
                }
                query.finish(ray);
                pending.around.flights.free.push(place);
                if let Some(stop) = pending.start::<S, Q>(query) {
                    stops.push(stop);
                }
            }
        }
    }
    if pending.around.rays_per_child.is_good() { coherence } else { Coherence::Incoherent }
}

/// Moves the rays that visit nodes next by one step.
///
/// The next visit of each ray is looked up in a second loop: in the first, these instructions would
/// wait for the outcome of a step, fill the CPU's schedulers, and fewer steps would overlap. If
/// nodes are far away, the loops take turns, so that prefetches start early and not all at once.
///
/// # Safety
/// As [`trace`].
#[inline(always)]
unsafe fn test_nodes<S: Steps>(memory: &Memory, flights: &Flights, stops: &mut Stops) {
    let len = stops.take(Stops::NODES);
    let turn = if S::IS_FAR { FAR_TURN } else { IN_FLIGHT };
    let mut begin = 0;
    // SAFETY: stops of this list are nodes, and rays in flight.
    unsafe {
        while begin < len {
            let end = len.min(begin + turn);
            for i in begin..end {
                let stop = stops.get(Stops::NODES, i);
                let node = memory.nodes.add(stop.child().0 as usize);
                memory.push_children::<S>(node, &mut *flights.ray(stop.place()), u8::MAX);
            }
            for i in begin..end {
                let place = stops.get(Stops::NODES, i).place();
                stops.push(Stop::new(place, memory.pop::<S>(&mut *flights.ray(place))));
            }
            begin = end;
        }
    }
}

/// Tests the blocks of triangles that rays visit next, several at once. If there are rays at nodes,
/// an incomplete group of blocks waits for others.
///
/// # Safety
/// As [`trace`].
#[inline(always)]
unsafe fn test_blocks<S: Steps, Q: Query>(memory: &Memory, flights: &Flights, stops: &mut Stops) {
    let may_wait = stops.len(Stops::NODES) > 0;
    let len = stops.take(Stops::BLOCKS);
    let now = if may_wait { len - len % S::BLOCKS } else { len };
    let mut hits = BlockHits::default();
    // SAFETY: stops of this list are blocks, and rays in flight.
    unsafe {
        let meeting = |stop: Stop| Meeting {
            block: memory.rows.add(stop.child().index() * S::ROWS),
            count: stop.child().block_len(),
            ray: flights.ray(stop.place()),
        };
        for first in (0..now).step_by(S::BLOCKS) {
            let count = (now - first).min(S::BLOCKS);
            // If there are too few, the last is repeated.
            let stop = |i: usize| stops.get(Stops::BLOCKS, first + i.min(count - 1));
            let mut group = [stop(0); MOST_BLOCKS];
            let mut meetings = [meeting(group[0]); MOST_BLOCKS];
            for i in 1..S::BLOCKS {
                group[i] = stop(i);
                meetings[i] = meeting(group[i]);
            }
            let set = S::blocks(&meetings, Q::ANY, &mut hits) & ((1 << (BLOCK * count)) - 1);
            if Q::ANY {
                for (i, meeting) in meetings[..count].iter().enumerate() {
                    let ray = &mut *meeting.ray;
                    ray.is_hit = u32::from(of_block(set, i) != 0);
                    let next = memory.pop::<S>(ray);
                    let next = if ray.is_hit != 0 { Child::DONE } else { next };
                    stops.push(Stop::new(group[i].place(), next));
                }
                continue;
            }
            let mut left = set;
            while left != 0 {
                let i = left.trailing_zeros() as usize / BLOCK % MOST_BLOCKS;
                let ray = &mut *meetings[i].ray;
                let t = ray.t;
                for lane in lanes_of(of_block(left, i)) {
                    let [t, u, v] = hits.get(i * BLOCK + lane);
                    let id = id_at(meetings[i].block, meetings[i].count, lane);
                    ray.offer(t, u, v, id);
                }
                if ray.t < t {
                    memory.cull::<S>(ray);
                }
                left &= u32::MAX << (BLOCK * i) << BLOCK;
            }
            for (stop, meeting) in group[..count].iter().zip(&meetings) {
                stops.push(Stop::new(stop.place(), memory.pop::<S>(&mut *meeting.ray)));
            }
        }
        for i in now..len {
            stops.push(stops.get(Stops::BLOCKS, i));
        }
    }
}

/// The lanes of the `i`-th block.
#[inline(always)]
fn of_block(lanes: u32, i: usize) -> u32 {
    lanes >> (BLOCK * i) & ((1 << BLOCK) - 1)
}
