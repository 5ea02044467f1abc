//! A kd-tree built by the surface area heuristic.
//!
//! Nodes have 8 bytes, siblings share a cache line, and a node tells which of its children are
//! empty. A leaf holds chunks of up to 16 triangles over shared vertices: about 45 bytes a triangle
//! beyond the primitives on closed meshes, references to split triangles included.
//!
//! Three ways lead through it, all to the same hits:
//!
//! - *Packets* of 16 rays (AVX-512) or 8 (AVX2) that go the same way, for coherent batches: a node
//!   costs two fused operations and two comparisons for all of them, and most triangles of a leaf
//!   are left out by bounds on all rays at once.
//! - A *stream* for rays that have nothing in common: one ray to a lane, nodes gathered, stacks in
//!   memory, leaves tested a register of triangles at a time, those of four leaves if they are small.
//!   It also takes over the lanes that packets leave alone, where there are many, and what is left
//!   of a coherent batch whose packets fall apart.
//! - One ray at a time, for lanes that packets leave alone where there are few, and in plain Rust as
//!   the twin of the others.
//!
//! Tried, and lost: scatters in place of the stream's scalar pushes, and four pushes without a
//! branch (no gain); more groups of rays under way (0.93); smaller and larger leaves by other costs
//! (within noise from half to twice the cost of a register, and for costs that favour leaves that
//! share a register). What counted most on some CPUs was to keep integers out of lanes that are
//! taken for numbers: as subnormals they made every step and every test 1.6 times as slow.

mod build;
mod leaf;
mod node;
#[cfg(target_arch = "x86_64")]
mod packet;
mod ray;
mod single;
#[cfg(target_arch = "x86_64")]
mod stream;
#[cfg(test)]
mod tests;
#[cfg(target_arch = "x86_64")]
mod x86;

#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::{__m256, __m512};

use build::MAX_DEPTH;
use leaf::{Arena, Best};
use node::Node;
use ray::Prepared;
use single::{Kernel, Portable, Visit};
#[cfg(target_arch = "x86_64")]
use stream::{Stream, Vector};

use super::order::{self, Order, Sixteen};
use super::{Coherence, Hits, Isa, LANES, NO_HIT, Primitives, Rays, pages};
use crate::math::Bounds;

/// A kd-tree over primitives.
#[derive(Debug)]
pub struct KdTree {
    primitives: Primitives,
    bounds: Bounds,
    nodes: Vec<Node>,
    arena: Arena,
    isa: Isa,
}

/// Working memory of queries, one per thread; holds nothing between calls.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    #[cfg(target_arch = "x86_64")]
    sixteens: Option<Stream<16, 2>>,
    #[cfg(target_arch = "x86_64")]
    eights: Option<Stream<8, 4>>,
    #[cfg(target_arch = "x86_64")]
    stack: Option<packet::Stack>,
    order: Order,
}

/// What is left of a batch.
struct Left<'a> {
    rays: &'a Rays,
    order: &'a Order,
    /// The sixteen that is taken next.
    next: usize,
}

impl<'a> Left<'a> {
    /// The next sixteen, and how many of them are rays to be traced.
    #[inline(always)]
    fn take(&mut self) -> Option<(Sixteen<'a>, usize)> {
        let order: &'a Order = self.order;
        let taken = order.get(self.next);
        self.next += usize::from(taken.is_some());
        taken
    }

    #[cfg(target_arch = "x86_64")]
    fn is_none(&self) -> bool {
        self.order.get(self.next).is_none()
    }
}

impl KdTree {
    /// Builds the tree.
    pub fn build(primitives: Primitives, isa: Isa) -> Self {
        let built = build::build(&primitives);
        pages::collapse(&built.nodes);
        pages::collapse(&built.arena.words);
        Self { primitives, bounds: built.bounds, nodes: built.nodes, arena: built.arena, isa }
    }

    pub(super) fn primitives(&self) -> &Primitives {
        &self.primitives
    }

    /// Bytes that it holds beyond the primitives.
    pub(super) fn memory(&self) -> usize {
        std::mem::size_of_val(self.nodes.as_slice())
            + std::mem::size_of_val(self.arena.words.as_slice())
    }

    pub(super) fn intersect(
        &self,
        rays: &Rays,
        coherence: Coherence,
        hits: &mut Hits,
        scratch: &mut Scratch,
    ) {
        self.trace::<false>(rays, coherence, scratch, &mut |i, best: &Best| {
            (hits.t[i], hits.u[i], hits.v[i]) = (best.t, best.u, best.v);
            hits.primitive[i] = best.primitive;
        });
    }

    pub(super) fn occluded(
        &self,
        rays: &Rays,
        coherence: Coherence,
        blocked: &mut [bool],
        scratch: &mut Scratch,
    ) {
        self.trace::<true>(rays, coherence, scratch, &mut |i, _: &Best| blocked[i] = true);
    }

    /// Tells every ray's nearest hit, of `ANY` the first that is found.
    fn trace<const ANY: bool>(
        &self,
        rays: &Rays,
        coherence: Coherence,
        scratch: &mut Scratch,
        done: &mut impl FnMut(usize, &Best),
    ) {
        match self.isa {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: a tree is built for an instruction set that the CPU has.
            Isa::Avx512 => unsafe { self.trace_avx512::<ANY>(rays, coherence, scratch, done) },
            #[cfg(target_arch = "x86_64")]
            // SAFETY: as above.
            Isa::Avx2 => unsafe { self.trace_avx2::<ANY>(rays, coherence, scratch, done) },
            _ => {
                scratch.order.keep(rays);
                self.trace_singly::<ANY>(Left { rays, order: &scratch.order, next: 0 }, done);
            }
        }
        #[cfg(not(target_arch = "x86_64"))]
        let _ = coherence;
    }

    /// # Safety
    /// The CPU has AVX-512 F, BW, DQ, VL, AVX2, FMA, BMI, LZCNT, and POPCNT.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    unsafe fn trace_avx512<const ANY: bool>(
        &self,
        rays: &Rays,
        coherence: Coherence,
        scratch: &mut Scratch,
        done: &mut impl FnMut(usize, &Best),
    ) {
        let Scratch { sixteens, stack, order, .. } = scratch;
        let stream = sixteens.get_or_insert_default();
        let stack = (coherence == Coherence::Coherent).then(|| stack.get_or_insert_default());
        // SAFETY: the caller's.
        unsafe { self.trace_wide::<__m512, 16, 2, ANY>(rays, order, stack, stream, done) }
    }

    /// # Safety
    /// The CPU has AVX2, FMA, BMI, LZCNT, and POPCNT.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    unsafe fn trace_avx2<const ANY: bool>(
        &self,
        rays: &Rays,
        coherence: Coherence,
        scratch: &mut Scratch,
        done: &mut impl FnMut(usize, &Best),
    ) {
        let Scratch { eights, stack, order, .. } = scratch;
        let stream = eights.get_or_insert_default();
        let stack = (coherence == Coherence::Coherent).then(|| stack.get_or_insert_default());
        // SAFETY: the caller's.
        unsafe { self.trace_wide::<__m256, 8, 4, ANY>(rays, order, stack, stream, done) }
    }

    /// Traces rays as a stream, with a `stack` in packets as long as those are worth their while.
    ///
    /// # Safety
    /// The CPU has the instructions of `V`.
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    unsafe fn trace_wide<V: Vector<N>, const N: usize, const GROUPS: usize, const ANY: bool>(
        &self,
        rays: &Rays,
        order: &mut Order,
        stack: Option<&mut packet::Stack>,
        stream: &mut Stream<N, GROUPS>,
        done: &mut impl FnMut(usize, &Best),
    ) {
        // SAFETY: the caller's.
        unsafe {
            let Some(stack) = stack else {
                order.keep(rays);
                let left = Left { rays, order, next: 0 };
                return stream::trace::<V, N, GROUPS, ANY>(self, left, None, stream, done);
            };
            order.sort::<V::Choosing>(rays);
            let left = Left { rays, order, next: 0 };
            let left = self.trace_together::<V, N, ANY>(left, stack, done);
            if !left.is_none() {
                stream::trace::<V, N, GROUPS, ANY>(self, left, Some(stack), stream, done);
            }
        }
    }

    /// Traces rays in packets, and those that go other ways or are left alone one by one, while
    /// packets are worth their while and leave few lanes alone; returns what is left.
    ///
    /// # Safety
    /// The CPU has the instructions of `V`.
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    unsafe fn trace_together<'a, V: Vector<N>, const N: usize, const ANY: bool>(
        &self,
        mut left: Left<'a>,
        stack: &mut packet::Stack,
        done: &mut impl FnMut(usize, &Best),
    ) -> Left<'a> {
        stack.begin();
        let rays = left.rays;
        let mut prepared = Prepared::<LANES>::EMPTY;
        while stack.is_good::<V>()
            && !stack.lets_go::<V>()
            && let Some((sixteen, count)) = left.take()
        {
            // SAFETY: the caller's.
            unsafe {
                prepared.take::<V::Choosing>(rays, sixteen, count, &self.bounds);
                let set = prepared.entering();
                let alone = packet::trace::<V, V::Kernel, ANY>(
                    self, rays, &prepared, set, stack, None, done,
                );
                self.trace_set::<V::Kernel, ANY>(rays, &prepared, alone, done);
            }
        }
        left
    }

    /// Traces rays one by one, in plain Rust.
    fn trace_singly<const ANY: bool>(&self, mut left: Left, done: &mut impl FnMut(usize, &Best)) {
        let mut prepared = Prepared::<LANES>::EMPTY;
        while let Some((sixteen, count)) = left.take() {
            // SAFETY: plain Rust runs on every CPU.
            unsafe {
                prepared.take::<order::Portable>(left.rays, sixteen, count, &self.bounds);
                self.trace_set::<Portable, ANY>(left.rays, &prepared, prepared.entering(), done);
            }
        }
    }

    /// Traces some of sixteen rays one by one.
    ///
    /// # Safety
    /// The CPU has the instructions of `K`.
    #[inline(always)]
    unsafe fn trace_set<K: Kernel, const ANY: bool>(
        &self,
        rays: &Rays,
        prepared: &Prepared<LANES>,
        mut set: u32,
        done: &mut impl FnMut(usize, &Best),
    ) {
        while set != 0 {
            let lane = set.trailing_zeros() as usize;
            set &= set - 1;
            let index = prepared.index[lane] as usize;
            let (near, far) = (prepared.near[lane], prepared.far[lane]);
            let root = Visit { node: Node::ROOT, near, far };
            let mut best = Best::up_to(prepared.t[lane]);
            // SAFETY: the caller's.
            unsafe {
                let ray = (rays, index);
                single::trace::<K, ANY, LANES>(self, prepared, lane, ray, root, &mut best);
            }
            if best.is_hit() {
                done(index, &best);
            }
        }
    }
}
