//! The places of rays in flight, each with a stack behind it.

use std::arch::x86_64::*;

use super::entries::{Entries, Line};
use super::ray::Ray;
use super::vector::Vector;
use crate::structure::kdtree::treelet::{Child, Stand, Stop, TOP, Treelet, cells_of};

/// The tree and the rays in flight as the inner loops see them.
#[derive(Clone, Copy)]
pub(crate) struct Memory {
    /// Treelets and leaves.
    pub(crate) words: *const u32,
    /// The first place of a ray.
    pub(crate) places: *mut Line,
    /// Entries of a stack: the length of each of its three arrays.
    pub(crate) stack: usize,
}

impl Memory {
    /// # Safety
    /// It is one of the tree.
    #[inline(always)]
    pub(crate) unsafe fn treelet(&self, child: Child) -> &Treelet {
        // SAFETY: the caller's.
        unsafe { &*self.words.add(child.0 as usize * Child::UNIT).cast() }
    }

    /// # Safety
    /// `place` is one of the places.
    #[inline(always)]
    pub(crate) unsafe fn ray(&self, place: u32) -> *mut Ray {
        // SAFETY: the caller's.
        unsafe { self.places.byte_add(place as usize).cast() }
    }

    /// # Safety
    /// The ray is in a place.
    #[inline(always)]
    unsafe fn stack(&self, ray: *mut Ray) -> Entries {
        // SAFETY: the caller's; the stack lies behind the ray.
        unsafe {
            let near = ray.add(1).cast::<f32>();
            Entries { near, far: near.add(self.stack), child: near.add(2 * self.stack).cast() }
        }
    }

    /// Pops the last entry of a ray's stack, and prefetches its memory: three lines whatever it is,
    /// or, if memory is far away, the one line of a treelet and four of a leaf.
    ///
    /// # Safety
    /// The ray is in a place, and its stack holds its first entry at least.
    #[inline(always)]
    pub(crate) unsafe fn pop<const FAR: bool>(&self, ray: *mut Ray) -> Child {
        // SAFETY: the caller's.
        let child = unsafe {
            (*ray).top -= 1;
            *self.stack(ray).child.add((*ray).top as usize)
        };
        // A prefetch of an invalid address does nothing.
        let at = self.words.wrapping_add(child.offset()).cast::<i8>();
        let lines = if FAR { 4 } else { 3 };
        let stride = if FAR && child.is_treelet() { 0 } else { size_of::<Line>() };
        for line in 0..lines {
            // SAFETY: a prefetch reads nothing.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(at.wrapping_add(stride * line)) };
        }
        child
    }

    /// Pushes the children of a treelet that was just popped.
    ///
    /// # Safety
    /// The CPU has the instructions of `V`; the ray is in a place.
    #[inline(always)]
    pub(crate) unsafe fn step<V: Vector>(&self, ray: *mut Ray, child: Child) {
        // SAFETY: the caller's; the stack has room for a step's entries, and what was taken is read
        // before it is written to.
        unsafe {
            let top = self.stack(ray).add((*ray).top as usize);
            self.push_cells::<V>(ray, self.treelet(child), [*top.near, *top.far], u8::MAX);
        }
    }

    /// Drops the entries of a ray's stack that begin behind its best hit. This is done when the hit
    /// is found, so that popping needs no loop whose end the CPU would have to predict.
    ///
    /// # Safety
    /// As [`step`](Self::step).
    #[inline(always)]
    pub(crate) unsafe fn cull<V: Vector>(&self, ray: *mut Ray) {
        // SAFETY: the caller's; a step's eight entries fit behind the last.
        unsafe { (*ray).top = V::cull(self.stack(ray), (*ray).top as usize, (*ray).t) as u32 }
    }

    /// Pushes children of a treelet on a ray's stack; returns their number.
    ///
    /// # Safety
    /// As [`step`](Self::step); the stack has room.
    #[inline(always)]
    pub(crate) unsafe fn push_cells<V: Vector>(
        &self,
        ray: *mut Ray,
        treelet: &Treelet,
        span: [f32; 2],
        among: u8,
    ) -> usize {
        // SAFETY: the caller's.
        unsafe {
            let top = self.stack(ray).add((*ray).top as usize);
            let count = V::children(treelet, &*ray, span, among, top);
            (*ray).top += count as u32;
            count
        }
    }

    /// An entry of a ray's stack: the child, and the span.
    ///
    /// # Safety
    /// The ray is in a place; there is such an entry.
    #[cfg(test)]
    pub(crate) unsafe fn entry(&self, ray: *mut Ray, i: usize) -> (u32, [f32; 2]) {
        // SAFETY: the caller's.
        unsafe {
            let Entries { near, far, child } = self.stack(ray).add(i);
            ((*child).0, [*near, *far])
        }
    }

    /// Pushes a part of the tree on a ray's stack, with the span of the ray in it.
    ///
    /// # Safety
    /// As [`step`](Self::step); the stack has room.
    #[inline(always)]
    pub(crate) unsafe fn push<V: Vector>(
        &self,
        ray: *mut Ray,
        Stand { at, plane }: Stand,
        span: [f32; 2],
    ) {
        // SAFETY: the caller's.
        unsafe {
            if plane == TOP {
                self.stack(ray).add((*ray).top as usize).set(span, at);
                (*ray).top += 1;
            } else {
                self.push_cells::<V>(ray, self.treelet(at), span, cells_of(plane));
            }
        }
    }
}

/// The places for rays in flight, each with a stack behind it.
pub(crate) struct Flights<'a> {
    pub(crate) memory: Memory,
    pub(crate) free: &'a mut Vec<u32>,
    /// Rays that left a packet and are in no list yet.
    pub(crate) parked: &'a mut Vec<u32>,
}

impl Flights<'_> {
    /// Puts a ray into a free place, at the root, which counts as popped already.
    ///
    /// # Safety
    /// A place is free.
    #[inline(always)]
    pub(crate) unsafe fn start(&mut self, ray: &Ray) -> Stop {
        // SAFETY: the caller's.
        unsafe {
            let place = self.put(ray);
            let home = self.memory.ray(place);
            self.memory.stack(home).add(1).set([ray.near, ray.far], Child::ROOT);
            Stop::new(place, Child::ROOT)
        }
    }

    /// Puts a ray into a free place, to join the stream when there is room. The caller fills its
    /// stack.
    ///
    /// # Safety
    /// A place is free.
    #[inline(always)]
    pub(crate) unsafe fn park(&mut self, ray: &Ray) -> *mut Ray {
        // SAFETY: the caller's.
        unsafe {
            let place = self.put(ray);
            self.parked.push(place);
            self.memory.ray(place)
        }
    }

    /// Puts a ray into a free place, with nothing but the end on its stack.
    ///
    /// # Safety
    /// A place is free.
    #[inline(always)]
    unsafe fn put(&mut self, ray: &Ray) -> u32 {
        // SAFETY: places lie within the lines, and have room for a ray and its stack.
        unsafe {
            let place = self.free.pop().unwrap_unchecked();
            let home = self.memory.ray(place);
            *home = *ray;
            (*home).top = 1;
            self.memory.stack(home).set([f32::NEG_INFINITY, 0.0], Child::DONE);
            place
        }
    }
}
