//! Rays in flight and their stacks.

use super::layout::{Child, Node, Stop};
use super::ray::Ray;
use super::steps::Steps;
use crate::simd::prefetch;

/// Lines of a [`Ray`].
pub(super) const RAY_LINES: usize = 2;

/// A cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Line(pub(super) [u8; 64]);

/// The places for rays in flight, each with a stack behind it.
pub(super) struct Flights<'a> {
    pub(super) first: *mut Line,
    pub(super) memory: Memory,
    pub(super) free: &'a mut Vec<u32>,
    /// Rays that left a packet and are in no list yet.
    pub(super) parked: &'a mut Vec<Stop>,
}

impl Flights<'_> {
    /// Puts a ray into a free place, with an empty stack.
    ///
    /// # Safety
    /// A place is free.
    #[inline(always)]
    pub(super) unsafe fn put(&mut self, ray: &Ray) -> u32 {
        // SAFETY: places lie within the lines, and have room for a ray and its stack.
        unsafe {
            let place = self.free.pop().unwrap_unchecked();
            let home = self.ray(place);
            *home = *ray;
            let first = home.add(1).cast::<f32>();
            *first = f32::NEG_INFINITY;
            *first.add(self.memory.stack).cast() = Child::DONE;
            (*home).top = first.add(1);
            place
        }
    }

    /// Puts a ray into a free place, to join the stream at `child` when there is room.
    ///
    /// # Safety
    /// A place is free.
    #[inline(always)]
    pub(super) unsafe fn park(&mut self, ray: Ray, child: Child) -> *mut Ray {
        // SAFETY: the caller's.
        unsafe {
            let place = self.put(&ray);
            self.parked.push(Stop::new(place, child));
            self.ray(place)
        }
    }

    /// # Safety
    /// `place` is one of the places.
    #[inline(always)]
    pub(super) unsafe fn ray(&self, place: u32) -> *mut Ray {
        // SAFETY: the caller's.
        unsafe { self.first.byte_add(place as usize).cast() }
    }
}

/// The hierarchy as the inner loops see it.
#[derive(Clone, Copy)]
pub(super) struct Memory {
    pub(super) nodes: *const Node,
    pub(super) rows: *const f32,
    /// Entries between a distance on a stack and the child that belongs to it.
    pub(super) stack: usize,
}

impl Memory {
    /// Pushes the children that a ray enters on its stack: of those in `among`, bit `s` for the
    /// child that is `s`-th from the far end.
    ///
    /// # Safety
    /// There is such a node, and room for eight entries; the CPU has the instruction set.
    #[inline(always)]
    pub(super) unsafe fn push_children<S: Steps>(
        &self,
        node: *const Node,
        ray: &mut Ray,
        among: u8,
    ) {
        // SAFETY: the caller's.
        unsafe {
            let count = S::children(node, ray, among, ray.top, ray.top.add(self.stack).cast());
            ray.top = ray.top.add(count);
        }
    }

    /// Pops the last entry of a ray's stack, and prefetches its memory.
    ///
    /// # Safety
    /// The ray's stack holds its first entry at least.
    #[inline(always)]
    pub(super) unsafe fn pop<S: Steps>(&self, ray: &mut Ray) -> Child {
        // SAFETY: the caller's.
        let child = unsafe {
            ray.top = ray.top.sub(1);
            *ray.top.add(self.stack).cast::<Child>()
        };
        self.prefetch::<S>(child);
        child
    }

    /// Drops the entries of a ray's stack that begin behind its best hit. This is done when the hit
    /// is found, so that popping needs no loop whose end the CPU would have to predict.
    ///
    /// # Safety
    /// The CPU has the instruction set; the ray's stack is the one behind it.
    #[inline(always)]
    pub(super) unsafe fn cull<S: Steps>(&self, ray: &mut Ray) {
        // SAFETY: the caller's; a step's eight entries fit behind the last.
        unsafe {
            let first = (&raw mut *ray).add(1).cast::<f32>();
            let len = ray.top.offset_from_unsigned(first);
            ray.top = first.add(S::cull(first, first.add(self.stack).cast(), len, ray.t));
        }
    }

    /// Prefetches the memory of a node or a block.
    #[inline(always)]
    fn prefetch<S: Steps>(&self, child: Child) {
        let node = self.nodes.wrapping_add(child.0 as usize).cast::<u8>();
        let block = self.rows.wrapping_add(child.index() * S::ROWS).cast::<u8>();
        let at = if child.is_leaf() { block } else { node };
        for line in 0..if S::MOVES { 7 } else { 4 } {
            let line = at.wrapping_add(64 * line);
            if S::IS_FAR { prefetch::<true>(line) } else { prefetch::<false>(line) }
        }
    }
}
