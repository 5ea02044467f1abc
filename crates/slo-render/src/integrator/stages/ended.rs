//! Rays that end: on a light, or on nothing.

use glam::Vec3;
use slo_accel::math::columns::{BATCH, Column, Vec3s};

use super::hits::Hits;
use crate::frame::{FrameScene, Look};
use crate::integrator::batch::Batch;
use crate::integrator::branching::mean_rays_to;
use crate::shading::Light;

/// Light of the rays that are not shaded: those to the background and to lights.
#[derive(Debug)]
pub(in crate::integrator) struct Ended {
    /// Weighted radiance.
    pub(in crate::integrator) light: Vec3s,
    pub(in crate::integrator) slot: Column<u32>,
    pub(in crate::integrator) len: usize,
}

impl Default for Ended {
    fn default() -> Self {
        Self { light: Vec3s::default(), slot: [0; BATCH], len: 0 }
    }
}

impl Ended {
    /// Finds the light of the rays of a batch that are not shaded.
    pub(in crate::integrator) fn find(
        &mut self,
        frame: &FrameScene,
        batch: &Batch,
        hits: &Hits,
        depth: u32,
    ) {
        let background = Vec3::from(frame.settings.background);
        self.len = 0;
        for i in hits.shaded.others(batch.len()) {
            let (color, share) = match Look::of_word(hits.looks[i]) {
                Look::Light(light) => {
                    let light = &frame.lights[light as usize];
                    let way = batch.rays.direction(i) * hits.found.hits.t[i];
                    (light.radiance(way), lobe_share(frame, light, way, batch.density[i], depth))
                }
                _ => (background, 1.0),
            };
            self.push(batch.weight.get(i) * color * share, batch.labels.slot[i]);
        }
    }

    #[inline(always)]
    fn push(&mut self, light: Vec3, slot: u32) {
        self.light.set(self.len, light);
        self.slot[self.len] = slot;
        self.len += 1;
    }
}

/// Weight of a lobe's ray that finds a lamp at the end of `way`, `depth` bounces behind the camera,
/// if rays to the lamp look for the same light and bring the rest of it: the balance heuristic.
fn lobe_share(frame: &FrameScene, light: &Light, way: Vec3, density: f32, depth: u32) -> f32 {
    if density == 0.0 {
        return 1.0;
    }
    density / (density + mean_rays_to(frame, light, depth - 1) * light.density(way))
}
