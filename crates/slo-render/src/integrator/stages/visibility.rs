//! Connections: rays that carry the light that they add if nothing blocks them.

use glam::Vec3;
use slo_accel::math::columns::Vec3s;
use slo_accel::{Coherence, Lanewise, NO_HIT};

use crate::frame::{FrameScene, NO_MATERIAL, SurfaceScratch, Surfaces, WorldHits, WorldScratch};
use crate::integrator::batch::{Batch, Labels, Sent};
use crate::integrator::chosen::Chosen;
use crate::integrator::queue::Habit;

/// A batch of connections, and their continuations behind transparent objects.
#[derive(Debug, Default)]
pub(in crate::integrator) struct Visibility {
    /// The batch. Tracing turns its weights into the light that arrives.
    pub(in crate::integrator) batch: Batch,
    blocked: Vec<bool>,
    passing: Option<Box<Passing>>,
}

/// Connections that pass through what they hit.
#[derive(Debug, Default)]
struct Passing {
    found: WorldHits,
    surfaces: Surfaces,
    scratch: SurfaceScratch,
    sent: Sent,
    labels: Labels,
    chosen: Chosen,
}

impl Visibility {
    /// Finds what blocks the connections of the batch.
    pub(in crate::integrator) fn trace(
        &mut self,
        frame: &FrameScene,
        habit: &mut Habit,
        scratch: &mut WorldScratch,
    ) {
        let expected = habit.expected();
        let alike = if frame.lets_light_pass() {
            let passing = self.passing.get_or_insert_default();
            passing.trace(frame, &mut self.batch, expected, scratch)
        } else {
            self.passing = None;
            self.trace_opaque(frame, expected, scratch)
        };
        habit.learn(expected, alike);
    }

    /// Returns the connections that start again behind the objects that they passed through: rays,
    /// labels, and the selection.
    pub(in crate::integrator) fn beyond(&self) -> Option<(&Sent, &Labels, &Chosen)> {
        let passing = self.passing.as_ref()?;
        Some((&passing.sent, &passing.labels, &passing.chosen))
    }

    /// Removes the light of blocked rays.
    fn trace_opaque(
        &mut self,
        frame: &FrameScene,
        expected: Coherence,
        scratch: &mut WorldScratch,
    ) -> Coherence {
        let Self { batch, blocked, .. } = self;
        let (rays, time) = (&batch.rays, &batch.labels.time);
        let alike = frame.world.occluded(rays, time, expected, blocked, scratch);
        frame.isa.run(Darken { blocked, light: &mut batch.weight });
        alike
    }
}

impl Passing {
    /// Removes the light of rays that hit something. Rays that hit something that lets light pass
    /// start again behind it, weaker.
    fn trace(
        &mut self,
        frame: &FrameScene,
        batch: &mut Batch,
        expected: Coherence,
        scratch: &mut WorldScratch,
    ) -> Coherence {
        let Self { found, surfaces, sent, labels, chosen, .. } = self;
        let (len, Batch { rays, weight, labels: Labels { time, slot, .. }, .. }) =
            (batch.len(), batch);
        let alike = frame.world.intersect(rays, time, expected, found, scratch);
        surfaces.len = 0;
        for i in 0..len {
            let primitive = found.hits.primitive[i];
            if primitive == NO_HIT {
                continue;
            }
            let light = weight.get(i);
            weight.set(i, Vec3::ZERO);
            let instance = found.instance[i];
            let look = frame.look_of(primitive, instance);
            if let Some(passed) = frame.light_passed(primitive, instance) {
                sent.weight.set(surfaces.len, light * passed);
                surfaces.push(i, NO_MATERIAL);
            } else if frame.may_pass(look) {
                sent.weight.set(surfaces.len, light);
                surfaces.push(i, look.material().unwrap_or(NO_MATERIAL));
            }
        }
        frame.find_surfaces(rays, time, found, surfaces, &mut self.scratch);
        for i in 0..surfaces.len {
            if surfaces.material[i] != NO_MATERIAL {
                let light = sent.weight.get(i) * frame.share_passing(surfaces, i);
                sent.weight.set(i, light);
            }
            let ray = surfaces.ray[i] as usize;
            let (origin, direction) = (rays.origin(ray), rays.direction(ray));
            let from = surfaces.leave(i, direction);
            sent.origin.set(i, from);
            let t_max = rays.t_max[ray];
            // The ray keeps its end, if it has one.
            let (direction, t_max) = if t_max < f32::INFINITY {
                (origin + direction * t_max - from, 1.0)
            } else {
                (direction, t_max)
            };
            sent.direction.set(i, direction);
            sent.t_max[i] = t_max;
            labels.time[i] = time[ray];
            labels.slot[i] = slot[ray];
        }
        chosen.set(frame.isa, surfaces.len, |i| sent.weight.get(i) != Vec3::ZERO);
        alike
    }
}

/// Sets the light of blocked rays to 0.
struct Darken<'a> {
    blocked: &'a [bool],
    light: &'a mut Vec3s,
}

impl Lanewise for Darken<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Vec3s { x, y, z } = self.light;
        for column in [x, y, z] {
            for (light, &blocked) in column.iter_mut().zip(self.blocked) {
                *light = if blocked { 0.0 } else { *light };
            }
        }
    }
}
