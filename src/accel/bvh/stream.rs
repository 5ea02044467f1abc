//! Many rays in flight at once, a step of each in turn.
//!
//! One ray alone waits for memory at every node, and for the outcome of every branch. Here a step
//! of a ray has next to no branches, ends by asking for the memory that the ray's next step needs,
//! and is followed by steps of other rays. Rays that stand before a node and rays that stand before
//! a leaf are kept in two lists, worked off in turn.

use super::Bvh;
use super::binary::BLOCK;
use super::layout::{Child, Corners, Node, WIDTH};
use super::ray::Ray;
use super::steps::{BlockHits, Steps};
use crate::accel::Rays;

/// Rays in flight.
const IN_FLIGHT: usize = 32;

/// Working memory of [`trace`].
#[derive(Debug, Default)]
pub(super) struct Stream {
    rays: Vec<Ray>,
    /// Stacks, one after the other: distances, and what to visit.
    ts: Vec<f32>,
    children: Vec<Child>,
    /// Rays that stand before a node, and before anything else.
    lists: [Vec<u32>; 3],
}

/// What is asked of a ray.
pub(super) trait Query {
    /// Whether the first hit will do.
    const ANY: bool;
    /// Takes a ray that is done.
    fn finish(&mut self, ray: &Ray);
}

/// Entries of the deepest stack, with room for one step's writing beyond it.
pub(super) fn stack_size(depth: usize) -> usize {
    1 + depth * (WIDTH - 1) + WIDTH
}

impl Stream {
    fn prepare(&mut self, stack: usize) {
        self.rays.resize(IN_FLIGHT, Ray::new(glam::Vec3::ZERO, glam::Vec3::ONE, 0.0));
        if self.ts.len() < IN_FLIGHT * stack {
            self.ts.resize(IN_FLIGHT * stack, 0.0);
            self.children.resize(IN_FLIGHT * stack, Child::DONE);
        }
        self.lists.iter_mut().for_each(|list| {
            list.clear();
            list.resize(IN_FLIGHT, 0);
        });
    }
}

/// Traces the rays of a batch that `pending` names; all are tame.
///
/// # Safety
/// The CPU has the instruction set of `S`.
#[inline(always)]
pub(super) unsafe fn trace<S: Steps, Q: Query>(
    bvh: &Bvh,
    rays: &Rays,
    pending: &[u32],
    query: &mut Q,
    stream: &mut Stream,
) {
    let stack = bvh.stack;
    stream.prepare(stack);
    let mut pending = pending.iter();
    let mut inner_len = 0;
    let mut leaf_len = 0;
    let Stream { rays: flying, ts, children, lists: [inner, next_inner, leaves] } = stream;
    let mut inner = inner.as_mut_ptr();
    let mut next_inner = next_inner.as_mut_ptr();
    let leaves = leaves.as_mut_ptr();
    let flying = flying.as_mut_ptr();
    let ts = ts.as_mut_ptr();
    let children = children.as_mut_ptr();
    let nodes = bvh.nodes.as_ptr();
    let rows = bvh.corners.rows().as_ptr();

    // SAFETY:
    // Lists: a ray stands in one list only, and there are as many rays as a list has places.
    // Stacks: a ray that stands at level l has left at most WIDTH - 1 entries for each level above
    // it, besides the first; a step writes WIDTH entries from its top on.
    // Nodes and blocks: children of a node are numbers of nodes and blocks that exist.
    unsafe {
        for slot in 0..IN_FLIGHT {
            let Some(&index) = pending.next() else { break };
            start(&mut *flying.add(slot), rays, index);
            *ts.add(slot * stack) = f32::NEG_INFINITY;
            *children.add(slot * stack) = Child::DONE;
            *inner.add(inner_len) = slot as u32;
            inner_len += 1;
        }
        while inner_len + leaf_len > 0 {
            let mut next_len = 0;
            for i in 0..inner_len {
                let slot = *inner.add(i) as usize;
                let ray = &mut *flying.add(slot);
                let (ts, children) = (ts.add(slot * stack), children.add(slot * stack));
                let top = ray.top as usize;
                let node = &*nodes.add(ray.current.0 as usize);
                let count = S::children(node, ray, ts.add(top), children.add(top));
                ray.top += count as u32;
                let next = pop(ray, ts, children);
                prefetch(nodes, rows, next);
                *next_inner.add(next_len) = slot as u32;
                *leaves.add(leaf_len) = slot as u32;
                next_len += usize::from(!next.is_leaf());
                leaf_len += usize::from(next.is_leaf());
            }
            let leaf_count = std::mem::take(&mut leaf_len);
            for i in 0..leaf_count {
                let slot = *leaves.add(i) as usize;
                let ray = &mut *flying.add(slot);
                let (ts, children) = (ts.add(slot * stack), children.add(slot * stack));
                let done = match ray.current.triangle_count() {
                    Some(count) => {
                        let first = ray.current.index();
                        let block = rows.add(first * Corners::PER_TRIANGLE);
                        if Q::ANY {
                            ray.is_hit = S::any_triangle(block, count, ray);
                            ray.is_hit
                        } else {
                            closest::<S>(bvh, block, first, count, ray);
                            false
                        }
                    }
                    None if ray.current != Child::DONE => {
                        bvh.test_curved(rays, ray);
                        Q::ANY && ray.is_hit
                    }
                    None => true,
                };
                let next = if done {
                    query.finish(ray);
                    let Some(&index) = pending.next() else { continue };
                    start(ray, rays, index);
                    ray.current
                } else {
                    let next = pop(ray, ts, children);
                    prefetch(nodes, rows, next);
                    next
                };
                *next_inner.add(next_len) = slot as u32;
                *leaves.add(leaf_len) = slot as u32;
                next_len += usize::from(!next.is_leaf());
                leaf_len += usize::from(next.is_leaf());
            }
            std::mem::swap(&mut inner, &mut next_inner);
            inner_len = next_len;
        }
    }
}

/// Puts a ray of the batch into flight, before the root.
#[inline(always)]
fn start(ray: &mut Ray, rays: &Rays, index: u32) {
    let i = index as usize;
    *ray = Ray::new(rays.origin(i), rays.direction(i), rays.t_max[i]);
    ray.index = index;
    ray.top = 1;
}

/// Takes entries from a ray's stack until one may hold a hit as near as the best.
///
/// # Safety
/// The first entry of the ray's stack has the distance of minus infinity.
#[inline(always)]
unsafe fn pop(ray: &mut Ray, ts: *const f32, children: *const Child) -> Child {
    // SAFETY: the first entry ends the search.
    unsafe {
        let mut top = ray.top as usize - 1;
        while *ts.add(top) > ray.t {
            top -= 1;
        }
        ray.top = top as u32;
        ray.current = *children.add(top);
        ray.current
    }
}

/// Keeps a hit that is nearer than the best, or as near and of lower id.
///
/// # Safety
/// As [`Steps::triangles`].
#[inline(always)]
unsafe fn closest<S: Steps>(
    bvh: &Bvh,
    block: *const f32,
    first: usize,
    count: usize,
    ray: &mut Ray,
) {
    let mut hits = BlockHits::default();
    // SAFETY: the caller's; slots of a block have ids.
    unsafe {
        let mut set = S::triangles(block, count, ray, &mut hits);
        while set != 0 {
            let lane = set.trailing_zeros() as usize & (BLOCK - 1);
            let id = *bvh.ids.get_unchecked(first + lane);
            ray.offer(hits.t[lane], hits.u[lane], hits.v[lane], id);
            set &= set - 1;
        }
    }
}

/// Asks for the memory of a node or a block.
#[inline(always)]
fn prefetch(nodes: *const Node, rows: *const f32, child: Child) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let node = nodes.wrapping_add(child.0 as usize).cast::<i8>();
        let block = rows.wrapping_add(child.index() * Corners::PER_TRIANGLE).cast::<i8>();
        let at = if child.is_leaf() { block } else { node };
        for line in 0..4 {
            // SAFETY: a prefetch reads nothing.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(at.wrapping_add(64 * line)) };
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (nodes, rows, child);
}
