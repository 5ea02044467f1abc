//! Light that surfaces emit toward the rays that hit them.

use glam::Vec3;
use slo_accel::math::columns::{BATCH, Column, Vec3s};

use super::arrived::share;
use super::bsdfs::Bsdfs;
use super::hits::Hits;
use super::points::Points;
use crate::frame::FrameScene;
use crate::integrator::batch::Batch;

/// Emitted light, weighted, one entry for each point.
#[derive(Debug)]
pub(in crate::integrator) struct Emission {
    pub(in crate::integrator) light: Vec3s,
    pub(in crate::integrator) slot: Column<u32>,
}

impl Default for Emission {
    fn default() -> Self {
        Self { light: Vec3s::default(), slot: [0; BATCH] }
    }
}

impl Emission {
    /// Computes the light that the points of a batch emit, after `depth` bounces. Returns whether
    /// there is any.
    pub(in crate::integrator) fn find(
        &mut self,
        frame: &FrameScene,
        batch: &Batch,
        hits: &Hits,
        points: &Points,
        bsdfs: &Bsdfs,
        depth: u32,
    ) -> bool {
        let mut any = false;
        for i in 0..points.len() {
            let emitted = bsdfs.emitted(i);
            let mut light = Vec3::ZERO;
            if emitted != Vec3::ZERO {
                any = true;
                let ray = points.surfaces.ray[i] as usize;
                let share = frame.emitter(&hits.found, ray).map_or(1.0, |number| {
                    let (from, time) = (batch.past.from.get(ray), batch.labels.time[ray]);
                    let way = points.surfaces.point.get(i) - from;
                    let by_point = frame.lights.density(number, time, from, way);
                    share(frame, number, (way, by_point), batch, ray, depth)
                });
                light = points.weight.get(i) * emitted * share;
            }
            self.light.set(i, light);
        }
        any
    }

    /// Finds the slots of the light: those of the points, in the groups of the objects, at a distance
    /// of `stride` from each other.
    pub(in crate::integrator) fn name(
        &mut self,
        frame: &FrameScene,
        hits: &Hits,
        points: &Points,
        stride: u32,
    ) {
        self.slot = points.labels.slot;
        if stride > 0 {
            for i in 0..points.len() {
                let ray = points.surfaces.ray[i] as usize;
                self.slot[i] += frame.group_of_object(&hits.found, ray) * stride;
            }
        }
    }
}
