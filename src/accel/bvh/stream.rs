//! Many rays in flight at once, a step of each in turn.
//!
//! One ray alone waits for memory at every node, and for the outcome of every branch. Here a step
//! of a ray has next to no branches, ends by asking for the memory that the ray's next step needs,
//! and is followed by steps of other rays. Rays that stand before a node and rays that stand before
//! a leaf are kept in lists, worked off in turn.

use super::Bvh;
use super::binary::BLOCK;
use super::layout::{Child, Corners, Node, WIDTH};
use super::ray::{Prepared, Ray};
use super::steps::{BlockHits, Steps};
use crate::accel::{LANES, Rays};

/// Rays in flight.
const IN_FLIGHT: usize = 32;

/// What is asked of a ray.
pub(super) trait Query {
    /// Whether the first hit will do.
    const ANY: bool;
    /// Takes a ray that is done.
    fn finish(&mut self, ray: &Ray);
}

/// Working memory of [`trace`].
#[derive(Debug)]
pub(super) struct Stream {
    prepared: Prepared,
    /// For each ray in flight itself, then its stack: distances, then what to visit.
    flights: Vec<Line>,
    lists: [[Stop; IN_FLIGHT]; 4],
}

#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Line([u8; 64]);

/// A ray in flight and what it stands before.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(8))]
struct Stop {
    /// Number of its first line.
    place: u32,
    child: Child,
}

impl Default for Stream {
    fn default() -> Self {
        let stop = Stop { place: 0, child: Child::DONE };
        Self { prepared: Prepared::EMPTY, flights: vec![], lists: [[stop; IN_FLIGHT]; 4] }
    }
}

/// Entries of the deepest stack, with room for one step's writing beyond it: a ray leaves at most
/// `WIDTH - 1` entries on each level, besides the first.
pub(super) fn stack_size(depth: usize) -> usize {
    1 + depth * (WIDTH - 1) + WIDTH
}

/// The rays of a batch that are still to be traced, made ready sixteen at a time.
struct Pending<'a> {
    rays: &'a Rays,
    prepared: &'a mut Prepared,
    next: usize,
}

impl Pending<'_> {
    /// Puts the next ray into `flight`, its stack behind it; none is left if not.
    #[inline(always)]
    fn start<Q: Query>(&mut self, bvh: &Bvh, query: &mut Q, flight: &mut Ray) -> bool {
        while self.next < self.rays.len() {
            let (index, lane) = (self.next, self.next % LANES);
            if lane == 0 {
                self.prepared.fill(self.rays, index);
            }
            self.next += 1;
            if !(self.prepared.t_max[lane] > 0.0) {
                continue;
            }
            if bvh.is_tame && self.prepared.is_tame[lane] {
                let stack = (&raw mut *flight).wrapping_add(1).cast::<f32>();
                *flight = Ray::new(self.prepared, lane, index as u32, stack.wrapping_add(1));
                return true;
            }
            let ray = Ray::new(self.prepared, lane, index as u32, std::ptr::null_mut());
            query.finish(&super::careful::trace(bvh, self.rays, ray, Q::ANY));
        }
        false
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
    query: &mut Q,
    stream: &mut Stream,
) {
    const { assert!(size_of::<Ray>() == 128) };
    // An odd number of lines, so that stacks do not compete for the same places of a cache.
    let lines = (2 + bvh.stack.div_ceil(8)) | 1;
    let Stream { prepared, flights, lists } = stream;
    flights.resize(flights.len().max(IN_FLIGHT * lines), Line([0; 64]));
    let mut pending = Pending { rays, prepared, next: 0 };
    let memory =
        Memory { nodes: bvh.nodes.as_ptr(), rows: bvh.corners.rows().as_ptr(), stack: bvh.stack };
    let flights = flights.as_mut_ptr();
    let [first, second, leaves, others] = lists;
    let mut nodes = List::new(first);
    let mut stops =
        Stops { nodes: List::new(second), leaves: List::new(leaves), others: List::new(others) };
    // SAFETY:
    // Lists: a ray stands in one list only, and there are as many rays as a list has places.
    // Stacks: there is room for `bvh.stack` entries behind each ray.
    // Nodes and blocks: children of a node are numbers of nodes and blocks that exist.
    unsafe {
        for i in 0..IN_FLIGHT {
            let ray = flights.add(i * lines).cast::<Ray>();
            if !pending.start(bvh, query, &mut *ray) {
                break;
            }
            let stack = ray.add(1).cast::<f32>();
            *stack = f32::NEG_INFINITY;
            *stack.add(bvh.stack).cast() = Child::DONE;
            nodes.push(Stop { place: (i * lines) as u32, child: Child::node(0) }, true);
        }
        loop {
            for i in 0..nodes.len {
                let Stop { place, child } = nodes.get(i);
                let ray = &mut *flights.add(place as usize).cast::<Ray>();
                let node = &*memory.nodes.add(child.0 as usize);
                let count = S::children(node, ray, ray.top, ray.top.add(memory.stack).cast());
                ray.top = ray.top.add(count);
                stops.push(place, memory.pop(ray));
            }
            for i in 0..stops.leaves.take() {
                let Stop { place, child } = stops.leaves.get(i);
                let ray = &mut *flights.add(place as usize).cast::<Ray>();
                let next = if test_leaf::<S, Q>(bvh, &memory, child, ray) {
                    Child::DONE
                } else {
                    memory.pop(ray)
                };
                stops.push(place, next);
            }
            for i in 0..stops.others.take() {
                let Stop { place, child } = stops.others.get(i);
                let ray = &mut *flights.add(place as usize).cast::<Ray>();
                if child != Child::DONE {
                    bvh.test_curved(rays, child, ray);
                    if !(Q::ANY && ray.is_hit) {
                        stops.push(place, memory.pop(ray));
                        continue;
                    }
                }
                query.finish(ray);
                if pending.start(bvh, query, ray) {
                    stops.push(place, Child::node(0));
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
struct Memory {
    nodes: *const Node,
    rows: *const f32,
    /// From a distance on a stack to what to visit there, in entries.
    stack: usize,
}

impl Memory {
    /// Takes entries from a ray's stack until one may hold a hit as near as the best, and asks for
    /// the memory of that.
    ///
    /// # Safety
    /// The ray's stack holds its first entry, whose distance is minus infinity.
    #[inline(always)]
    unsafe fn pop(&self, ray: &mut Ray) -> Child {
        // SAFETY: the first entry ends the search.
        let child = unsafe {
            let mut top = ray.top.sub(1);
            while *top > ray.t {
                top = top.sub(1);
            }
            ray.top = top;
            *top.add(self.stack).cast::<Child>()
        };
        self.prefetch(child);
        child
    }

    /// Asks for the memory of a node or a block.
    #[inline(always)]
    fn prefetch(&self, child: Child) {
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
