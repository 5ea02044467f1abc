//! Light that surfaces emit toward the rays that hit them.

use glam::Vec3;
use slo_accel::math::columns::{BATCH, Column, Vec3s};

use super::arrived::{End, share};
use super::bsdfs::Bsdfs;
use super::hits::Hits;
use super::points::Points;
use crate::frame::FrameScene;
use crate::integrator::batch::{Batch, marks};

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
    /// there is any. Rays that ask a light bring that of this light alone.
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
                let emitter = frame.emitter(&hits.found, ray);
                let asked = if depth > 0 { marks::asked(batch.past.marks[ray]) } else { 0 };
                let share = if asked > 0 {
                    let is_asked = emitter == Some(frame.first_shaded + asked - 1);
                    if is_asked { 1.0 } else { 0.0 }
                } else {
                    emitter.map_or(1.0, |light| {
                        let (from, time) = (batch.past.from.get(ray), batch.labels.time[ray]);
                        let way = points.surfaces.point.get(i) - from;
                        let density = frame.lights.density(light, time, from, way);
                        // Rays from inside of a sphere don't ask it.
                        let density = if density.is_finite() { density } else { 0.0 };
                        share(frame, End { light, way, density }, batch, ray, depth)
                    })
                };
                light = points.weight.get(i) * emitted * share;
            }
            self.light.set(i, light);
        }
        any
    }

    /// Ends the paths of rays that ask a light.
    pub(in crate::integrator) fn end(batch: &Batch, points: &mut Points, depth: u32) {
        for i in 0..points.len() {
            let ray = points.surfaces.ray[i] as usize;
            if depth > 0 && marks::asked(batch.past.marks[ray]) != 0 {
                points.weight.set(i, Vec3::ZERO);
            }
        }
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
