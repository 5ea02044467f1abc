//! Light of paths that end on a lamp or in the sky.

use glam::Vec3;
use slo_accel::math::columns::{BATCH, Column, Vec3s};
use slo_scene::LightSampling;

use super::hits::Hits;
use crate::frame::{FrameScene, Look};
use crate::integrator::batch::{Batch, marks};
use crate::integrator::branching::rays_to;

/// Light of the rays that are not shaded.
#[derive(Debug)]
pub(in crate::integrator) struct Arrived {
    /// Weighted radiance.
    pub(in crate::integrator) light: Vec3s,
    pub(in crate::integrator) slot: Column<u32>,
    pub(in crate::integrator) len: usize,
}

impl Default for Arrived {
    fn default() -> Self {
        Self { light: Vec3s::default(), slot: [0; BATCH], len: 0 }
    }
}

impl Arrived {
    /// Computes the light of the rays of a batch, after `depth` bounces, that are not shaded.
    pub(in crate::integrator) fn find(
        &mut self,
        frame: &FrameScene,
        batch: &Batch,
        hits: &Hits,
        depth: u32,
    ) {
        self.len = 0;
        for i in hits.shaded.others(batch.len()) {
            let light = match Look::of_word(hits.looks[i]) {
                Look::Light(number) if depth == 0 && frame.is_hidden(number) => Vec3::ZERO,
                Look::Light(number) => {
                    let way = batch.rays.origin(i) + batch.rays.direction(i) * hits.found.hits.t[i]
                        - batch.past.from.get(i);
                    let way = if depth == 0 { batch.rays.direction(i) } else { way };
                    let light = &frame.lights[number as usize];
                    light.radiance(way) * share(frame, number, way, batch, i, depth)
                }
                Look::Nothing | Look::Material(_) => sky(frame, batch, i, depth),
            };
            self.light.set(self.len, batch.weight.get(i) * light);
            self.slot[self.len] = batch.labels.slot[i];
            self.len += 1;
        }
    }
}

/// Returns the light of all that is infinitely far away.
fn sky(frame: &FrameScene, batch: &Batch, i: usize, depth: u32) -> Vec3 {
    let direction = batch.rays.direction(i);
    let mut light = Vec3::from(frame.settings.background);
    for &number in &frame.skies {
        let sky = &frame.lights[number as usize];
        let radiance = sky.radiance(direction);
        if radiance != Vec3::ZERO {
            light += radiance * share(frame, number, direction, batch, i, depth);
        }
    }
    light
}

/// Returns the weight, by the balance heuristic, of ray `i`, which ends on a lamp after `depth`
/// bounces at the end of the vector `way` from the hit that it left.
pub(super) fn share(
    frame: &FrameScene,
    number: u32,
    way: Vec3,
    batch: &Batch,
    i: usize,
    depth: u32,
) -> f32 {
    let (density, is_diffuse) = (batch.density[i], batch.past.marks[i] & marks::DIFFUSE != 0);
    if depth == 0 {
        return 1.0;
    }
    let light = &frame.lights[number as usize];
    if is_diffuse && light.is_of_thesis() {
        return 0.0;
    }
    if density == 0.0 {
        return 1.0;
    }
    let rays = rays_to(frame, light, depth - 1) as f32;
    let chance = match frame.settings.light_sampling() {
        LightSampling::All => 1.0,
        LightSampling::One => {
            frame.light_tree.chance(number, batch.past.from.get(i), batch.past.normal[i])
        }
    };
    frame.techniques.hit(
        is_diffuse,
        density,
        rays * chance * light.density(batch.past.from.get(i), way),
    )
}
