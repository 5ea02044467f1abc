//! Structures to study, over primitives: what the renderer may choose. A device may traverse them, if it
//! is given one.

use std::sync::atomic::{AtomicBool, Ordering};

use glam::Vec3;

use super::answer::Answer;
use super::counting::{Counting, Counts};
use super::memory::Memory;
use super::ray::Ray;
use super::{Parameters, Statistics, Study};
use crate::isa::Isa;
use crate::math::Bounds;
use crate::primitives::Primitives;
use crate::primitives::triangle::TriangleHit;
use crate::rays::{Coherence, Hits, NO_HIT, Rays};
use crate::structure::device::{Device, Uploaded};
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
    device: Option<OnDevice<S>>,
}

/// The triangles of a structure on a device.
#[derive(Debug)]
struct OnDevice<S> {
    uploaded: Box<dyn Uploaded>,
    /// The curved surfaces, which no device knows; their ids begin with 0.
    curved: Option<Box<Rendered<S>>>,
    has_failed: AtomicBool,
}

impl<S> OnDevice<S> {
    /// The device's answers about all rays, in `answers`; false if it has failed, now or before.
    fn answer(&self, rays: &Rays, any: bool, answers: &mut Vec<Answer>) -> bool {
        let mut fails = || self.uploaded.trace(rays, any, answers).is_err();
        if self.has_failed.load(Ordering::Relaxed) || fails() {
            self.has_failed.store(true, Ordering::Relaxed);
            return false;
        }
        answers.len() >= rays.len()
    }
}

/// A ray for [`Rendered::trace`].
fn ray(rays: &Rays, i: usize) -> Ray {
    Ray { origin: rays.origin(i), direction: rays.direction(i), t_max: rays.t_max[i] }
}

impl<S: Study> SpatialIndex for Rendered<S> {
    type Geometry = Primitives;
    type Scratch = Memory;

    fn build(primitives: Primitives, options: BuildOptions) -> Self {
        let all = 0..primitives.len() as u32;
        let ids: Vec<u32> = all.filter(|&id| can_be_hit(&primitives, id)).collect();
        let objects: Vec<Bounds> = ids.iter().map(|&id| primitives.bounds(id)).collect();
        let study = S::build(&objects, &options.parameters);
        Self { primitives, ids, study, isa: options.isa, device: None }
    }

    fn upload(&mut self, device: &dyn Device) -> Result<(), String> {
        let Primitives { triangles, curved } = &self.primitives;
        if triangles.is_empty() {
            return Ok(());
        }
        let reason =
            "a device traverses grids, kd-trees and hierarchies of boxes, without mailboxes";
        let layout = self.study.layout().ok_or(reason)?;
        // What has no corners is never hit there.
        let triangle = |&id: &u32| triangles.get(id as usize).copied().unwrap_or([Vec3::ZERO; 3]);
        let triangles: Vec<_> = self.ids.iter().map(triangle).collect();
        let uploaded = device.upload(&layout, &triangles)?;
        let curved = (!curved.is_empty()).then(|| {
            let primitives = Primitives { triangles: vec![], curved: curved.clone() };
            let options = BuildOptions::new(self.isa).with_parameters(Parameters::default());
            Box::new(Self::build(primitives, options))
        });
        self.device = Some(OnDevice { uploaded, curved, has_failed: AtomicBool::new(false) });
        Ok(())
    }

    #[inline]
    fn geometry(&self) -> &Primitives {
        &self.primitives
    }

    fn overhead(&self) -> usize {
        let on_device = self.device.as_ref().map_or(0, |device| {
            let curved = device.curved.as_ref();
            device.uploaded.bytes() + curved.map_or(0, |curved| curved.overhead())
        });
        size_of_val(self.ids.as_slice()) + self.study.bytes() + on_device
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
        self.trace(&ray(rays, i), any, memory, counts).map_or(f32::INFINITY, |(hit, _)| hit.t)
    }

    fn intersect(
        &self,
        rays: &Rays,
        coherence: Coherence,
        hits: &mut Hits,
        memory: &mut Memory,
    ) -> Coherence {
        self.trace_all(rays, false, memory, |i, hit, id| {
            (hits.t[i], hits.u[i], hits.v[i]) = (hit.t, hit.u, hit.v);
            hits.primitive[i] = id;
        });
        coherence
    }

    fn occluded(
        &self,
        rays: &Rays,
        coherence: Coherence,
        blocked: &mut [bool],
        memory: &mut Memory,
    ) -> Coherence {
        self.trace_all(rays, true, memory, |i, _, _| blocked[i] = true);
        coherence
    }
}

impl<S: Study> Rendered<S> {
    /// Calls `found` with the first hit of each ray that has one, or any hit if that is enough.
    fn trace_all(
        &self,
        rays: &Rays,
        any: bool,
        memory: &mut Memory,
        mut found: impl FnMut(usize, TriangleHit, u32),
    ) {
        let mut answers = std::mem::take(&mut memory.answers);
        let device = self.device.as_ref().filter(|device| device.answer(rays, any, &mut answers));
        for (i, ray) in (0..rays.len()).map(|i| (i, ray(rays, i))) {
            let hit = match device {
                Some(device) => self.confirm(device, &ray, any, &answers[i], memory),
                None => self.trace(&ray, any, memory, &mut ()),
            };
            if let Some((hit, id)) = hit {
                found(i, hit, id);
            }
        }
        memory.answers = answers;
    }

    /// The hit that a device has found, by the CPU's arithmetic, unless a curved surface is nearer.
    fn confirm(
        &self,
        device: &OnDevice<S>,
        ray: &Ray,
        any: bool,
        answer: &Answer,
        memory: &mut Memory,
    ) -> Option<(TriangleHit, u32)> {
        let of_triangle = if answer.object == NO_HIT {
            None
        } else {
            let id = self.ids.get(answer.object as usize);
            id.and_then(|&id| {
                let single = Single::new(ray.origin, ray.direction, self.isa);
                Some((single.test(&self.primitives, id, ray.t_max)?, id))
            })
        };
        let is_contradicted = answer.object != NO_HIT && of_triangle.is_none();
        if !answer.is_certain || is_contradicted {
            return self.trace(ray, any, memory, &mut ());
        }
        let Some(curved) = &device.curved else { return of_triangle };
        if any && of_triangle.is_some() {
            return of_triangle;
        }
        // At the same distance the triangle wins, whose id is lower.
        let before = Ray { t_max: of_triangle.map_or(ray.t_max, |(hit, _)| hit.t), ..*ray };
        let of_curved = curved.trace(&before, any, memory, &mut ());
        let first = self.primitives.triangles.len() as u32;
        of_curved.map(|(hit, id)| (hit, first + id)).or(of_triangle)
    }

    /// The first hit of a ray and its id, or any if that is enough.
    fn trace<C: Counting>(
        &self,
        ray: &Ray,
        any: bool,
        memory: &mut Memory,
        counting: &mut C,
    ) -> Option<(TriangleHit, u32)> {
        let single = Single::new(ray.origin, ray.direction, self.isa);
        let mut best: Option<(TriangleHit, u32)> = None;
        self.study.walk(ray, memory, counting, |object, t_max| {
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
