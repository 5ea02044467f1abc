//! A kd-tree, built by the surface area heuristic.
//!
//! Three levels of planes are a *treelet*: seven planes and eight children in one cache line. A
//! leaf holds chunks of up to 16 triangles over shared vertices: about 45 bytes a triangle beyond
//! the primitives on closed meshes, references to split triangles included. Treelets and leaves lie
//! in one array, so that a child's place is its address, whatever its kind.
//!
//! Three kernels traverse it, with the same hits:
//!
//! - *Packets* of 16 rays (AVX-512) or 8 (AVX2) that go the same way, for coherent batches: a plane
//!   costs two fused operations and two comparisons for all of them, and most triangles of a leaf
//!   are left out since they lie beside all rays (`view`).
//! - A *stream* for rays that have nothing in common: many in flight, a treelet for one of them at
//!   a time without a branch, leaves tested a register of triangles at once, those of several rays
//!   if they are small. Neighbours that start next to each other are brought down to there together
//!   first (`descent`). It also takes over the lanes that packets leave alone, and what is left of
//!   a coherent batch whose packets fall apart, or wait for memory that is far away.
//! - One ray at a time in plain Rust, as the twin of the others; the only one on AArch64.

mod builder;
#[cfg(target_arch = "x86_64")]
mod descent;
#[cfg(target_arch = "x86_64")]
mod flight;
mod leaf;
#[cfg(target_arch = "x86_64")]
mod packet;
mod query;
mod ray;
mod single;
#[cfg(target_arch = "x86_64")]
mod stream;
#[cfg(test)]
mod tests;
mod tree;
mod treelet;
#[cfg(target_arch = "x86_64")]
mod view;

#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::{__m256, __m512};

use self::query::{Blocked, Nearest, Query};
use self::ray::Prepared;
pub(super) use self::tree::KdTree;
#[cfg(target_arch = "x86_64")]
use crate::isa::Isa;
use crate::primitives::Primitives;
use crate::rays::{Coherence, Hits, LANES, Rays};
use crate::simd::lanes_of;
use crate::structure::interface::{BuildOptions, SpatialIndex};
use crate::structure::shared::order::{Order, Sixteen};
use crate::structure::study::Counts;

/// Working memory of queries, one per thread; holds nothing between calls.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    #[cfg(target_arch = "x86_64")]
    stream: Option<Box<stream::Stream>>,
    order: Order,
}

impl SpatialIndex for KdTree {
    type Geometry = Primitives;
    type Scratch = Scratch;

    fn build(primitives: Primitives, BuildOptions { isa, .. }: BuildOptions) -> Self {
        builder::build(primitives, isa)
    }

    #[inline]
    fn geometry(&self) -> &Primitives {
        &self.primitives
    }

    fn overhead(&self) -> usize {
        self.bytes()
    }

    fn can_count(&self) -> bool {
        true
    }

    fn count(&self, rays: &Rays, i: usize, any: bool, _: &mut Scratch, counts: &mut Counts) -> f32 {
        if self.bounds.is_empty() {
            return f32::INFINITY;
        }
        let (mut prepared, lane) = (Prepared::EMPTY, i % LANES);
        prepared.take(rays, Sixteen::Neighbours(i - lane), LANES, &self.bounds);
        if prepared.entering() >> lane & 1 == 0 {
            return f32::INFINITY;
        }
        let best = self.trace_one(any, &prepared, lane, rays, counts);
        if best.is_hit() { best.t } else { f32::INFINITY }
    }

    fn intersect(
        &self,
        rays: &Rays,
        coherence: Coherence,
        hits: &mut Hits,
        scratch: &mut Scratch,
    ) -> Coherence {
        self.trace(rays, coherence, scratch, &mut Nearest { hits });
        coherence
    }

    fn occluded(
        &self,
        rays: &Rays,
        coherence: Coherence,
        blocked: &mut [bool],
        scratch: &mut Scratch,
    ) -> Coherence {
        self.trace(rays, coherence, scratch, &mut Blocked { blocked });
        coherence
    }
}

impl KdTree {
    /// Answers a query about each ray.
    fn trace<Q: Query>(
        &self,
        rays: &Rays,
        coherence: Coherence,
        scratch: &mut Scratch,
        query: &mut Q,
    ) {
        if self.bounds.is_empty() {
            return;
        }
        match self.isa {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: a tree is built for an instruction set that the CPU has.
            Isa::Avx512 => unsafe { self.trace_avx512(rays, coherence, scratch, query) },
            #[cfg(target_arch = "x86_64")]
            // SAFETY: as above.
            Isa::Avx2 => unsafe { self.trace_avx2(rays, coherence, scratch, query) },
            _ => self.trace_singly(rays, &mut scratch.order, query),
        }
        #[cfg(not(target_arch = "x86_64"))]
        let _ = coherence;
    }

    /// # Safety
    /// The CPU has AVX-512 F, BW, DQ, VL, AVX2, FMA, BMI, LZCNT, and POPCNT.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    unsafe fn trace_avx512<Q: Query>(
        &self,
        rays: &Rays,
        coherence: Coherence,
        Scratch { stream, order }: &mut Scratch,
        query: &mut Q,
    ) {
        let stream = stream.get_or_insert_default();
        // SAFETY: the caller's.
        unsafe {
            if self.is_far {
                stream::trace::<__m512, Q, 4, true>(self, rays, coherence, order, stream, query)
            } else {
                stream::trace::<__m512, Q, 4, false>(self, rays, coherence, order, stream, query)
            }
        }
    }

    /// # Safety
    /// The CPU has AVX2, FMA, BMI, LZCNT, and POPCNT.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    unsafe fn trace_avx2<Q: Query>(
        &self,
        rays: &Rays,
        coherence: Coherence,
        Scratch { stream, order }: &mut Scratch,
        query: &mut Q,
    ) {
        let stream = stream.get_or_insert_default();
        // SAFETY: the caller's.
        unsafe {
            if self.is_far {
                stream::trace::<__m256, Q, 2, true>(self, rays, coherence, order, stream, query)
            } else {
                stream::trace::<__m256, Q, 2, false>(self, rays, coherence, order, stream, query)
            }
        }
    }

    /// Traces rays one by one, in plain Rust.
    fn trace_singly<Q: Query>(&self, rays: &Rays, order: &mut Order, query: &mut Q) {
        order.keep(rays);
        let mut prepared = Prepared::EMPTY;
        let mut next = 0;
        while let Some((sixteen, count)) = order.get(next) {
            next += 1;
            prepared.take(rays, sixteen, count, &self.bounds);
            for lane in lanes_of(prepared.entering()) {
                let best = self.trace_one(Q::ANY, &prepared, lane, rays, &mut ());
                if best.is_hit() {
                    query.accept(prepared.index[lane] as usize, &best);
                }
            }
        }
    }
}
