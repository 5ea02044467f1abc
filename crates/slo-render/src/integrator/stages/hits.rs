//! The first hits of a batch, and which of them are shaded.

use slo_accel::math::columns::{BATCH, Column};

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
