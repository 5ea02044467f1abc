//! Streams: many rays in flight, a step of each in turn.
//!
//! A single ray waits for memory at every treelet, and for the outcome of every branch. Here a step
//! of a ray has no branch ([`flight`](super::flight)), ends by prefetching the memory of the ray's
//! next step, and is followed by steps of other rays. Rays that visit a treelet next and rays that
//! visit a leaf next are kept in lists, which take turns.

mod leaves;

use super::descent;
use super::flight::{Flights, Line, Memory, RAY_LINES, Ray, Vector, stack_size};
use super::packet::{self, Surroundings, Use};
use super::query::Query;
use super::ray::Prepared;
use super::tree::KdTree;
use super::treelet::{Child, Stop, Stops};
use crate::rays::{Coherence, LANES, Rays};
use crate::structure::shared::order::Order;
use crate::structure::shared::stops::{IN_FLIGHT, Lists};

/// Working memory of [`trace`].
#[derive(Debug)]
pub(super) struct Stream {
    prepared: Prepared,
    /// Sixteen rays.
    ready: [Line; LANES * RAY_LINES],
    packets: packet::Stack,
    pub(super) path: descent::Path,
    /// For each place the ray itself, then its stack.
    lines: Vec<Line>,
    free: Vec<u32>,
    parked: Vec<u32>,
    lists: Lists<Child>,
    #[cfg(test)]
    pub(super) took_over: bool,
}

impl Default for Stream {
    fn default() -> Self {
        Self {
            prepared: Prepared::EMPTY,
            ready: [Line::EMPTY; LANES * RAY_LINES],
            packets: packet::Stack::default(),
            path: descent::Path::default(),
            lines: vec![],
            free: vec![],
            parked: vec![],
            lists: [[Stop::NONE; IN_FLIGHT]; 4],
            #[cfg(test)]
            took_over: false,
        }
    }
}

/// The rays of a batch that remain to be traced, prepared sixteen at a time.
struct Pending<'a> {
    around: Surroundings<'a>,
    path: &'a mut descent::Path,
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
    unsafe fn start<V: Vector, Q: Query, const FAR: bool>(
        &mut self,
        query: &mut Q,
    ) -> Option<Stop> {
        // SAFETY: the caller's; packets leave no more rays than there are places besides, and none
        // is parked when the next is made.
        unsafe {
            loop {
                let flights = &mut self.around.flights;
                if let Some(place) = flights.parked.pop() {
                    let memory = flights.memory;
                    return Some(Stop::new(place, memory.pop::<FAR>(memory.ray(place))));
                }
                if self.left != 0 {
                    let lane = self.left.trailing_zeros() as usize;
                    self.left &= self.left - 1;
                    return Some(flights.start(&self.ready[lane % LANES]));
                }
                self.prepare::<V, Q, FAR>(query)?;
            }
        }
    }

    /// Prepares sixteen rays, if any are left, and traces those that go in packets.
    ///
    /// # Safety
    /// As [`start`](Self::start).
    #[inline(always)]
    unsafe fn prepare<V: Vector, Q: Query, const FAR: bool>(
        &mut self,
        query: &mut Q,
    ) -> Option<()> {
        let (sixteen, count) = self.order.get(self.next)?;
        self.next += 1;
        let Surroundings { tree, rays, .. } = self.around;
        // SAFETY: the caller's; any bits are a ray.
        unsafe {
            self.prepared.take(rays, sixteen, count, &tree.bounds);
            self.left = self.prepared.entering();
            if self.packets && self.around.used.is_good::<V, FAR>() {
                self.left =
                    packet::trace::<V, Q>(&mut self.around, self.prepared, self.left, query);
            }
            if self.left != 0 {
                Ray::deal::<V>(self.prepared, self.ready);
                let flights = &mut self.around.flights;
                self.left =
                    descent::descend::<V>(self.path, flights, self.prepared, self.ready, self.left);
            }
        }
        Some(())
    }
}

/// Answers a query about rays; coherent rays go in packets while these pay. A register has `QUADS`
/// times four lanes; `FAR` says whether the tree is far away.
///
/// # Safety
/// The CPU has the instructions of `V`.
#[inline(always)]
pub(super) unsafe fn trace<V: Vector, Q: Query, const QUADS: usize, const FAR: bool>(
    tree: &KdTree,
    rays: &Rays,
    coherence: Coherence,
    order: &mut Order,
    stream: &mut Stream,
    query: &mut Q,
) {
    let packets = coherence == Coherence::Coherent;
    if packets {
        // SAFETY: the caller's.
        unsafe { order.sort::<V::Choosing>(rays) }
    } else {
        order.keep(rays)
    }
    let size = stack_size(tree.depth);
    // An odd number of lines, so that stacks do not compete for the same places of a cache.
    let lines = (RAY_LINES + (3 * size).div_ceil(size_of::<Line>() / 4)) | 1;
    let Stream { prepared, ready, packets: stack, path, lines: room, free, parked, lists, .. } =
        stream;
    const PLACES: usize = IN_FLIGHT + LANES;
    room.resize(room.len().max(PLACES * lines), Line::EMPTY);
    free.clear();
    free.extend((0..PLACES).rev().map(|i| (i * lines * size_of::<Line>()) as u32));
    parked.clear();
    let memory = Memory { words: tree.words().as_ptr(), places: room.as_mut_ptr(), stack: size };
    let flights = Flights { memory, free, parked };
    let around = Surroundings { tree, rays, stack, flights, used: Use::default() };
    // SAFETY: any bits are a ray; lines are aligned as rays are, and as long as sixteen.
    let ready = unsafe { &mut *ready.as_mut_ptr().cast::<[Ray; LANES]>() };
    let mut pending = Pending { around, path, prepared, ready, packets, order, next: 0, left: 0 };
    let mut stops = Stops::new(lists);
    // SAFETY:
    // Lists: a ray stands in one list only, and there are as many rays as a list has places.
    // Stacks: there is room for the deepest behind each ray.
    // Treelets and leaves: children of a treelet are places of those that exist.
    unsafe {
        for _ in 0..IN_FLIGHT {
            let Some(stop) = pending.start::<V, Q, FAR>(query) else { break };
            stops.push(stop);
        }
        while !stops.are_none() {
            for i in 0..stops.take(Child::TREELETS) {
                let stop = stops.get(Child::TREELETS, i);
                let ray = memory.ray(stop.place());
                memory.step::<V>(ray, stop.child());
                stops.push(Stop::new(stop.place(), memory.pop::<FAR>(ray)));
            }
            leaves::visit_quarters::<V, Q, QUADS, FAR>(&memory, &mut stops);
            leaves::visit_wholes::<V, Q, FAR>(&memory, &mut stops);
            for i in 0..stops.take(Child::OTHERS) {
                let stop = stops.get(Child::OTHERS, i);
                let (place, child) = (stop.place(), stop.child());
                let ray = memory.ray(place);
                if child != Child::DONE {
                    leaves::visit_any::<V, Q>(&memory, tree, rays, child, ray);
                    if !(Q::ANY && (*ray).is_hit()) {
                        stops.push(Stop::new(place, memory.pop::<FAR>(ray)));
                        continue;
                    }
                }
                if (*ray).is_hit() {
                    query.accept((*ray).index as usize, &(*ray).best());
                }
                pending.around.flights.free.push(place);
                if let Some(stop) = pending.start::<V, Q, FAR>(query) {
                    stops.push(stop);
                }
            }
        }
    }
    #[cfg(test)]
    {
        stream.took_over |= pending.around.used.lets_go;
    }
}
