//! The first hits of a batch, and which of them are shaded.

use slo_accel::NO_HIT;
use slo_accel::instances::NO_INSTANCE;
use slo_accel::math::columns::{BATCH, Column};

use super::camera_rays::CameraRays;
use crate::frame::{FrameScene, Look, WorldHits, WorldScratch};
use crate::integrator::batch::Batch;
use crate::integrator::chosen::Chosen;
use crate::integrator::queue::Habit;

/// First hits of the rays of a batch.
#[derive(Debug)]
pub(in crate::integrator) struct Hits {
    pub(super) found: WorldHits,
    /// What each ray sees, as a word of [`Look`].
    pub(super) looks: Column<u32>,
    /// Hits on surfaces with a material.
    pub(super) shaded: Chosen,
}

impl Default for Hits {
    fn default() -> Self {
        Self { found: WorldHits::default(), looks: [0; BATCH], shaded: Chosen::default() }
    }
}

impl Hits {
    /// If the pixels are texels, takes their points as hits, and returns true.
    pub(in crate::integrator) fn take_texels(
        &mut self,
        frame: &FrameScene,
        batch: &Batch,
        camera_rays: &CameraRays,
    ) -> bool {
        let Some(baked) = &frame.baked else { return false };
        let Self { found: WorldHits { hits, instance }, looks, shaded } = self;
        hits.reset(batch.len());
        instance.clear();
        instance.resize(batch.len(), NO_INSTANCE);
        for (i, point) in camera_rays.points().iter().enumerate() {
            looks[i] = Look::NOTHING;
            let Some(point) = point else { continue };
            looks[i] = baked.white;
            (hits.primitive[i], instance[i]) = (point.primitive, point.instance);
            [hits.u[i], hits.v[i]] = point.uv;
            hits.t[i] = (batch.rays.origin(i) - point.point).length();
        }
        shaded.set(frame.isa, batch.len(), |i| Look::is_material(looks[i]));
        true
    }

    /// Returns the number of the object that a ray hit, and the distance; `None` if it hit nothing.
    pub(in crate::integrator) fn thing(
        &self,
        frame: &FrameScene,
        ray: usize,
    ) -> Option<(u32, f32)> {
        let WorldHits { hits, instance } = &self.found;
        let primitive = hits.primitive[ray];
        let thing = || frame.object_of(primitive, instance[ray]);
        (primitive != NO_HIT).then(|| (thing(), hits.t[ray]))
    }

    /// Finds the first hits of the rays of a batch.
    pub(in crate::integrator) fn trace(
        &mut self,
        frame: &FrameScene,
        batch: &Batch,
        habit: &mut Habit,
        scratch: &mut WorldScratch,
    ) {
        let Self { found, looks, shaded } = self;
        let (rays, time, expected) = (&batch.rays, &batch.labels.time, habit.expected());
        habit.learn(expected, frame.world.intersect(rays, time, expected, found, scratch));
        frame.find_looks(found, looks);
        shaded.set(frame.isa, batch.len(), |i| Look::is_material(looks[i]));
    }
}
