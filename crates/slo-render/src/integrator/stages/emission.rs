//! Light that surfaces emit toward the rays that hit them.

use glam::Vec3;
use slo_accel::math::columns::Vec3s;

use super::arrived::share;
use super::bsdfs::Bsdfs;
use super::hits::Hits;
use super::points::Points;
use crate::frame::FrameScene;
use crate::integrator::batch::Batch;

/// Emitted light, weighted, one entry for each point.
#[derive(Debug, Default)]
pub(in crate::integrator) struct Emission {
    pub(in crate::integrator) light: Vec3s,
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
                    let way = points.surfaces.point.get(i) - batch.past.from.get(ray);
                    share(frame, number, way, batch, ray, depth)
                });
                light = points.weight.get(i) * emitted * share;
            }
            self.light.set(i, light);
        }
        any
    }
}
