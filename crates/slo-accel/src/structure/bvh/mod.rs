//! A bounding volume hierarchy of eight children to a node, traced in streams of many rays.
//!
//! Leaves hold the triangles themselves, in blocks of up to four as rows of coordinates. This is
//! the only copy; a table finds a triangle by its id. A triangle that was cut may be in several
//! leaves.

mod builder;
mod careful;
#[cfg_attr(not(target_arch = "x86_64"), allow(dead_code))]
mod flights;
pub(crate) mod halting;
mod hierarchy;
mod layout;
#[cfg_attr(not(target_arch = "x86_64"), allow(dead_code))]
mod packet;
mod query;
mod ray;
mod steps;
mod stream;
#[cfg(test)]
mod tests;
#[cfg(target_arch = "x86_64")]
mod x86;

pub(super) use self::hierarchy::Bvh;
use self::query::{Any, Closest, Query};
use self::steps::Portable;
#[cfg(target_arch = "x86_64")]
use crate::isa::Isa;
use crate::math::Bounds;
use crate::primitives::Primitives;
use crate::rays::{Coherence, Hits, Rays};
use crate::structure::interface::{BuildOptions, SpatialIndex};

/// Working memory of queries.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    stream: stream::Stream,
}

impl SpatialIndex for Bvh {
    type Geometry = Self;
    type Scratch = Scratch;

    fn build(primitives: Primitives, options: BuildOptions) -> Self {
        builder::build(primitives, options)
    }

    #[inline]
    fn geometry(&self) -> &Self {
        self
    }

    fn parts(&self, count: usize) -> Vec<Bounds> {
        halting::parts(&self.nodes, count)
    }

    fn overhead(&self) -> usize {
        size_of_val(&*self.nodes)
    }

    fn intersect(
        &self,
        rays: &Rays,
        coherence: Coherence,
        hits: &mut Hits,
        scratch: &mut Scratch,
    ) -> Coherence {
        self.run(rays, coherence, &mut Closest { hits }, scratch)
    }

    fn occluded(
        &self,
        rays: &Rays,
        coherence: Coherence,
        blocked: &mut [bool],
        scratch: &mut Scratch,
    ) -> Coherence {
        self.run(rays, coherence, &mut Any { blocked }, scratch)
    }
}

impl Bvh {
    fn run<Q: Query>(
        &self,
        rays: &Rays,
        coherence: Coherence,
        query: &mut Q,
        scratch: &mut Scratch,
    ) -> Coherence {
        if self.nodes.is_empty() {
            return coherence;
        }
        let stream = &mut scratch.stream;
        // SAFETY: the set is one that the CPU has.
        unsafe {
            match (self.isa, self.is_far) {
                #[cfg(target_arch = "x86_64")]
                (Isa::Avx512, false) => {
                    stream_avx512::<Q, false>(self, rays, coherence, query, stream)
                }
                #[cfg(target_arch = "x86_64")]
                (Isa::Avx512, true) => {
                    stream_avx512::<Q, true>(self, rays, coherence, query, stream)
                }
                #[cfg(target_arch = "x86_64")]
                (Isa::Avx2, false) => stream_avx2::<Q, false>(self, rays, coherence, query, stream),
                #[cfg(target_arch = "x86_64")]
                (Isa::Avx2, true) => stream_avx2::<Q, true>(self, rays, coherence, query, stream),
                _ => stream::trace::<Portable, Q>(self, rays, coherence, query, stream),
            }
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512dq,avx512vl")]
unsafe fn stream_avx512<Q: Query, const FAR: bool>(
    bvh: &Bvh,
    rays: &Rays,
    coherence: Coherence,
    query: &mut Q,
    stream: &mut stream::Stream,
) -> Coherence {
    // SAFETY: the caller's.
    unsafe { stream::trace::<x86::Avx512<FAR>, Q>(bvh, rays, coherence, query, stream) }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
unsafe fn stream_avx2<Q: Query, const FAR: bool>(
    bvh: &Bvh,
    rays: &Rays,
    coherence: Coherence,
    query: &mut Q,
    stream: &mut stream::Stream,
) -> Coherence {
    // SAFETY: the caller's.
    unsafe { stream::trace::<x86::Avx2<FAR>, Q>(bvh, rays, coherence, query, stream) }
}
