//! Rays that end on a light or in the background.

use glam::Vec3;
use slo_accel::math::columns::{BATCH, Column, Vec3s};

use super::hits::Hits;
use crate::frame::{FrameScene, Look};
use crate::integrator::batch::Batch;
use crate::integrator::branching::mean_rays_to;
use crate::shading::Light;

/// Light of the rays that are not shaded: rays to the background and to lights.
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
    /// Computes the light of the rays of a batch that are not shaded.
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
                    let ray = [batch.rays.origin(i), way];
                    (light.radiance(way), lobe_share(frame, light, ray, batch.density[i], depth))
                }
                Look::Nothing | Look::Material(_) => (background, 1.0),
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

/// Returns the weight, by the balance heuristic, of a lobe's ray that hits a lamp after `depth`
/// bounces, at the end of the vector `way` from its origin. It is 1 if no rays to the lamp sample the same light.
fn lobe_share(
    frame: &FrameScene,
    light: &Light,
    [from, way]: [Vec3; 2],
    density: f32,
    depth: u32,
) -> f32 {
    if density == 0.0 {
        return 1.0;
    }
    density / (density + mean_rays_to(frame, light, depth - 1) * light.density(from, way))
}
