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
//! - A *stream* for rays that have nothing in common (AVX-512): one ray to a lane, nodes gathered,
//!   stacks in memory, leaves tested 16 triangles at a time. It also takes over what is left of a
//!   coherent batch whose packets fall apart.
//! - One ray at a time, for what is left elsewhere (8 triangles at a time on AVX2), and in plain
//!   Rust as the twin of the others.
//!
//! Tried, and lost: scatters in place of the stream's scalar pushes (no gain); more groups of rays
//! under way (0.93); smaller and larger leaves by other costs (within noise from half to twice the
//! cost of a register). What counted most on some CPUs was to keep integers out of lanes that are
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

use build::MAX_DEPTH;
use leaf::{Arena, Best};
use node::Node;
use ray::Prepared;
use single::{Kernel, Portable, Visit};

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
    stream: Option<stream::Stream>,
    #[cfg(target_arch = "x86_64")]
    stack: Option<packet::Stack>,
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
            // SAFETY: plain Rust runs on every CPU.
            _ => unsafe { self.trace_singly::<Portable, ANY>(rays, 0, done) },
        }
        #[cfg(not(target_arch = "x86_64"))]
        let _ = (coherence, scratch);
    }

    /// # Safety
    /// The CPU has AVX-512 F, BW, DQ, VL, AVX2, and FMA.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    unsafe fn trace_avx512<const ANY: bool>(
        &self,
        rays: &Rays,
        coherence: Coherence,
        scratch: &mut Scratch,
        done: &mut impl FnMut(usize, &Best),
    ) {
        // SAFETY: the caller's.
        unsafe {
            type Sixteen = std::arch::x86_64::__m512;
            let mut first = 0;
            if coherence == Coherence::Coherent {
                let stack = scratch.stack.get_or_insert_default();
                first = self.trace_together::<Sixteen, x86::Avx512, ANY>(rays, stack, done);
            }
            if first < rays.len() {
                let stream = scratch.stream.get_or_insert_default();
                stream::trace::<ANY>(self, rays, first, stream, done);
            }
        }
    }

    /// # Safety
    /// The CPU has AVX2 and FMA.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    unsafe fn trace_avx2<const ANY: bool>(
        &self,
        rays: &Rays,
        coherence: Coherence,
        scratch: &mut Scratch,
        done: &mut impl FnMut(usize, &Best),
    ) {
        // SAFETY: the caller's.
        unsafe {
            type Eight = std::arch::x86_64::__m256;
            let mut first = 0;
            if coherence == Coherence::Coherent {
                let stack = scratch.stack.get_or_insert_default();
                first = self.trace_together::<Eight, x86::Avx2, ANY>(rays, stack, done);
            }
            self.trace_singly::<x86::Avx2, ANY>(rays, first, done);
        }
    }

    /// Traces rays in packets, and those that go other ways one by one, while packets are worth
    /// their while; returns the first ray that is left, a multiple of sixteen if any is.
    ///
    /// # Safety
    /// The CPU has the instructions of `L` and of `K`.
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    unsafe fn trace_together<L: super::simd::Lanes, K: Kernel, const ANY: bool>(
        &self,
        rays: &Rays,
        stack: &mut packet::Stack,
        done: &mut impl FnMut(usize, &Best),
    ) -> usize {
        stack.begin();
        let mut prepared = Prepared::<LANES>::EMPTY;
        for first in (0..rays.len()).step_by(LANES) {
            if !stack.is_good::<L>() {
                return first;
            }
            prepared.fill(rays, first, &self.bounds);
            let set = prepared.entering();
            // SAFETY: the caller's.
            unsafe {
                let left = packet::trace::<L, K, ANY>(self, rays, &prepared, set, stack, done);
                self.trace_set::<K, ANY>(rays, &prepared, left, done);
            }
        }
        rays.len()
    }

    /// Traces rays one by one, from `first` on, a multiple of sixteen.
    ///
    /// # Safety
    /// The CPU has the instructions of `K`.
    #[inline(always)]
    unsafe fn trace_singly<K: Kernel, const ANY: bool>(
        &self,
        rays: &Rays,
        first: usize,
        done: &mut impl FnMut(usize, &Best),
    ) {
        let mut prepared = Prepared::<LANES>::EMPTY;
        for first in (first..rays.len()).step_by(LANES) {
            prepared.fill(rays, first, &self.bounds);
            // SAFETY: the caller's.
            unsafe { self.trace_set::<K, ANY>(rays, &prepared, prepared.entering(), done) };
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
