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
#[cfg(target_arch = "aarch64")]
mod neon;
#[cfg_attr(not(target_arch = "x86_64"), allow(dead_code))]
mod packet;
#[cfg_attr(not(target_arch = "x86_64"), allow(dead_code))]
mod quads;
mod query;
mod ray;
mod steps;
mod stream;
#[cfg(test)]
pub(super) mod tests;
#[cfg(target_arch = "x86_64")]
mod x86;

use std::borrow::Cow;

use self::builder::Shapes;
#[cfg(test)]
pub(super) use self::builder::is_never_hit;
pub(super) use self::hierarchy::Bvh;
use self::query::{Any, Closest, Query};
use self::steps::Portable;
use crate::isa::Isa;
use crate::math::Bounds;
use crate::primitives::{Primitives, Triangle};
use crate::rays::{Coherence, Hits, LANES, Rays};
use crate::structure::interface::{BuildOptions, Sections, SpatialIndex};
use crate::structure::study::{Counts, Statistics};

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

    fn kept(&self) -> Option<Vec<Cow<'_, [u8]>>> {
        Some(builder::kept(self))
    }

    fn restore(
        primitives: Primitives,
        options: BuildOptions,
        sections: &dyn Sections,
    ) -> Result<Self, Primitives> {
        builder::restore(primitives, options, sections)
    }

    fn refitted(
        &self,
        primitives: &Primitives,
        most_growth: f64,
        options: BuildOptions,
    ) -> Option<Self> {
        let shapes = Shapes { starts: &primitives.triangles, ends: None };
        let is_plain = primitives.curved.is_empty() && !options.spatial_splits;
        if is_plain { builder::refit(self, &shapes, most_growth, options.isa) } else { None }
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

    fn statistics(&self) -> Option<Statistics> {
        Some(self.made_of())
    }

    fn can_count(&self) -> bool {
        true
    }

    fn count(&self, rays: &Rays, i: usize, any: bool, _: &mut Scratch, counts: &mut Counts) -> f32 {
        if self.nodes.is_empty() || rays.t_max[i].is_nan() || rays.t_max[i] <= 0.0 {
            return f32::INFINITY;
        }
        let mut prepared = ray::Prepared::EMPTY;
        prepared.fill(rays, i / LANES * LANES);
        let ray = ray::Ray::new(&prepared, i % LANES);
        let ray = careful::trace(self, rays, ray, any, counts);
        if ray.is_hit != 0 { ray.t } else { f32::INFINITY }
    }

    fn intersect(
        &self,
        rays: &Rays,
        coherence: Coherence,
        hits: &mut Hits,
        scratch: &mut Scratch,
    ) -> Coherence {
        self.run::<_, false>((rays, &[]), coherence, &mut Closest { hits }, scratch)
    }

    fn occluded(
        &self,
        rays: &Rays,
        coherence: Coherence,
        blocked: &mut [bool],
        scratch: &mut Scratch,
    ) -> Coherence {
        self.run::<_, false>((rays, &[]), coherence, &mut Any { blocked }, scratch)
    }
}

impl Bvh {
    /// Builds the hierarchy over triangles whose corners move, each from where it is in the first
    /// shape to where it is in the second. Queries are those with a time.
    pub(super) fn build_moving(starts: &[Triangle], ends: &[Triangle], isa: Isa) -> Self {
        builder::build_moving(starts, ends, isa)
    }

    /// The same, made of this one, unless rays would cost more than `most_growth` times as much.
    pub(super) fn refitted_moving(
        &self,
        starts: &[Triangle],
        ends: &[Triangle],
        most_growth: f64,
        isa: Isa,
    ) -> Option<Self> {
        builder::refit(self, &Shapes { starts, ends: Some(ends) }, most_growth, isa)
    }

    /// As [`SpatialIndex::intersect`], for a hierarchy that moves: each ray has a time from 0 to 1.
    pub(super) fn intersect_at(
        &self,
        batch: (&Rays, &[f32]),
        coherence: Coherence,
        hits: &mut Hits,
        scratch: &mut Scratch,
    ) -> Coherence {
        self.run::<_, true>(batch, coherence, &mut Closest { hits }, scratch)
    }

    /// As [`SpatialIndex::occluded`], for a hierarchy that moves: each ray has a time from 0 to 1.
    pub(super) fn occluded_at(
        &self,
        batch: (&Rays, &[f32]),
        coherence: Coherence,
        blocked: &mut [bool],
        scratch: &mut Scratch,
    ) -> Coherence {
        self.run::<_, true>(batch, coherence, &mut Any { blocked }, scratch)
    }

    fn run<Q: Query, const MOVES: bool>(
        &self,
        batch: (&Rays, &[f32]),
        coherence: Coherence,
        query: &mut Q,
        scratch: &mut Scratch,
    ) -> Coherence {
        assert_eq!(self.moves, MOVES);
        if MOVES {
            assert!(batch.0.len() <= batch.1.len(), "a time for each ray");
        }
        if self.nodes.is_empty() || batch.0.is_empty() {
            return coherence;
        }
        let stream = &mut scratch.stream;
        // SAFETY: the set is one that the CPU has.
        unsafe {
            match self.isa {
                #[cfg(target_arch = "x86_64")]
                Isa::Avx512 | Isa::Avx2 => {
                    x86::trace::<_, MOVES>(self, batch, coherence, query, stream)
                }
                #[cfg(target_arch = "aarch64")]
                Isa::Neon => neon::trace::<_, MOVES>(self, batch, coherence, query, stream),
                _ => stream::trace::<Portable<MOVES>, _>(self, batch, coherence, query, stream),
            }
        }
    }
}
