//! Structures to study, over primitives: what the renderer may choose.

use super::counting::{Counting, Counts};
use super::memory::Memory;
use super::ray::Ray;
use super::{Statistics, Study};
use crate::isa::Isa;
use crate::math::Bounds;
use crate::primitives::Primitives;
use crate::primitives::triangle::TriangleHit;
use crate::rays::{Coherence, Hits, Rays};
use crate::structure::interface::{BuildOptions, SpatialIndex};
use crate::structure::shared::single::{Single, can_be_hit};

/// A structure over primitives: each is an object.
#[derive(Debug)]
pub(crate) struct Rendered<S> {
    primitives: Primitives,
    /// Ids of the objects, in their order.
    ids: Vec<u32>,
    study: S,
    isa: Isa,
}

impl<S: Study> SpatialIndex for Rendered<S> {
    type Geometry = Primitives;
    type Scratch = Memory;

    fn build(primitives: Primitives, options: BuildOptions) -> Self {
        let all = 0..primitives.len() as u32;
        let ids: Vec<u32> = all.filter(|&id| can_be_hit(&primitives, id)).collect();
        let objects: Vec<Bounds> = ids.iter().map(|&id| primitives.bounds(id)).collect();
        let study = S::build(&objects, &options.parameters);
        Self { primitives, ids, study, isa: options.isa }
    }

    #[inline]
    fn geometry(&self) -> &Primitives {
        &self.primitives
    }

    fn overhead(&self) -> usize {
        size_of_val(self.ids.as_slice()) + self.study.bytes()
    }

    fn statistics(&self) -> Option<Statistics> {
        let mut statistics = self.study.statistics();
        if self.primitives.curved.is_empty() {
            let triangle = |&id: &u32| self.primitives.triangles[id as usize];
            let surfaces: Vec<_> = (0..).zip(self.ids.iter().map(triangle)).collect();
            statistics.epo = self.study.end_point_overlap(&surfaces);
        }
        Some(statistics)
    }

    fn can_count(&self) -> bool {
        true
    }

    fn count(
        &self,
        rays: &Rays,
        i: usize,
        any: bool,
        memory: &mut Memory,
        counts: &mut Counts,
    ) -> f32 {
        self.trace(rays, i, any, memory, counts).map_or(f32::INFINITY, |(hit, _)| hit.t)
    }

    fn intersect(
        &self,
        rays: &Rays,
        coherence: Coherence,
        hits: &mut Hits,
        memory: &mut Memory,
    ) -> Coherence {
        for i in 0..rays.len() {
            if let Some((hit, id)) = self.trace(rays, i, false, memory, &mut ()) {
                (hits.t[i], hits.u[i], hits.v[i]) = (hit.t, hit.u, hit.v);
                hits.primitive[i] = id;
            }
        }
        coherence
    }

    fn occluded(
        &self,
        rays: &Rays,
        coherence: Coherence,
        blocked: &mut [bool],
        memory: &mut Memory,
    ) -> Coherence {
        for (i, blocked) in blocked.iter_mut().enumerate().take(rays.len()) {
            *blocked = self.trace(rays, i, true, memory, &mut ()).is_some();
        }
        coherence
    }
}

impl<S: Study> Rendered<S> {
    /// The first hit of a ray and its id, or any if that is enough.
    fn trace<C: Counting>(
        &self,
        rays: &Rays,
        i: usize,
        any: bool,
        memory: &mut Memory,
        counting: &mut C,
    ) -> Option<(TriangleHit, u32)> {
        let (origin, direction, t_max) = (rays.origin(i), rays.direction(i), rays.t_max[i]);
        let single = Single::new(origin, direction, self.isa);
        let mut best: Option<(TriangleHit, u32)> = None;
        let ray = Ray { origin, direction, t_max };
        self.study.walk(&ray, memory, counting, |object, t_max| {
            let id = self.ids[object as usize];
            // A hit as near as the best counts if its id is lower.
            let is_lower = best.is_some_and(|(_, lowest)| id < lowest);
            let limit = if is_lower { t_max.next_up() } else { t_max };
            match single.test(&self.primitives, id, limit) {
                Some(hit) => {
                    best = Some((hit, id));
                    if any { f32::NEG_INFINITY } else { hit.t }
                }
                None => t_max,
            }
        });
        best
    }
}
