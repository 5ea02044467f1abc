//! Light of paths that end on a lamp or in the sky.

use glam::Vec3;
use slo_accel::math::columns::{BATCH, Column, Vec3s};

use super::hits::Hits;
use crate::frame::{FrameScene, Look};
use crate::integrator::batch::{Batch, Past, marks};
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

/// Returns the number of parts of the light of the rays of a batch. Each sky is a part of its own if
/// the light of groups of lights is told apart.
pub(in crate::integrator) fn arrived_parts(frame: &FrameScene, stride: u32) -> usize {
    if stride > 0 { frame.skies.len().max(1) } else { 1 }
}

impl Arrived {
    /// Computes the light of the rays of a batch, after `depth` bounces, that are not shaded: a part
    /// of it. `stride` is the distance between the slots of two groups of lights; 0 if they are not
    /// told apart.
    pub(in crate::integrator) fn find(
        &mut self,
        frame: &FrameScene,
        batch: &Batch,
        hits: &Hits,
        depth: u32,
        (stride, part): (u32, usize),
    ) {
        self.len = 0;
        let skies = if stride > 0 { frame.skies.get(part..=part) } else { Some(&frame.skies[..]) };
        let skies = skies.unwrap_or_default();
        for i in hits.shaded.others(batch.len()) {
            if depth > 0 && marks::asked(batch.past.marks[i]) != 0 {
                continue;
            }
            let (light, first) = match Look::of_word(hits.looks[i]) {
                Look::Light(number) if depth == 0 && frame.is_hidden(number) => continue,
                Look::Light(_) if part > 0 => continue,
                Look::Light(number) => (lamp(frame, number, batch, hits, i, depth), Some(number)),
                Look::Nothing | Look::Material(_) => {
                    let first = skies.first().copied();
                    let background = Vec3::from(frame.settings.background);
                    let background = if part > 0 { Vec3::ZERO } else { background };
                    (background + sky(frame, skies, batch, i, depth), first)
                }
            };
            let group = first.filter(|_| stride > 0).map_or(0, |number| frame.group_of(number));
            self.light.set(self.len, batch.weight.get(i) * light);
            self.slot[self.len] = batch.labels.slot[i] + group * stride;
            self.len += 1;
        }
    }
}

/// Returns the light of a lamp that ray `i` hits.
fn lamp(frame: &FrameScene, number: u32, batch: &Batch, hits: &Hits, i: usize, depth: u32) -> Vec3 {
    let along = batch.rays.direction(i) * hits.found.hits.t[i];
    let from = if depth == 0 { batch.rays.origin(i) } else { batch.past.from.get(i) };
    let way = batch.rays.origin(i) + along - from;
    let time = batch.labels.time[i];
    if frame.lights.enclose(number, time, batch.rays.origin(i)) {
        return Vec3::ZERO;
    }
    light(frame, number, [from, way], batch, i, depth)
}

/// Returns the light of skies.
fn sky(frame: &FrameScene, skies: &[u32], batch: &Batch, i: usize, depth: u32) -> Vec3 {
    let direction = batch.rays.direction(i);
    let from = batch.past.from.get(i);
    let mut sum = Vec3::ZERO;
    for &number in skies {
        if depth == 0 && frame.is_hidden(number) {
            continue;
        }
        sum += light(frame, number, [from, direction], batch, i, depth);
    }
    sum
}

/// Where a ray ends on a light.
#[derive(Clone, Copy)]
pub(super) struct End {
    /// Index of the light.
    pub(super) light: u32,
    /// Vector from the hit that the ray left.
    pub(super) way: Vec3,
    /// See [`Lamp::density`](crate::shading::Lamp::density).
    pub(super) density: f32,
}

/// Returns the light of a lamp at the end of the vector `way`, weighted by its share.
fn light(
    frame: &FrameScene,
    number: u32,
    [from, way]: [Vec3; 2],
    batch: &Batch,
    i: usize,
    depth: u32,
) -> Vec3 {
    let time = batch.labels.time[i];
    if depth == 0 {
        return frame.lights.radiance(number, time, way);
    }
    let (radiance, density) = frame.lights.found(number, time, from, way);
    if radiance == Vec3::ZERO {
        return radiance;
    }
    radiance * share(frame, End { light: number, way, density }, batch, i, depth)
}

/// Returns the weight, by the balance heuristic, of ray `i`, which ends on a lamp after `depth`
/// bounces.
pub(super) fn share(frame: &FrameScene, end: End, batch: &Batch, i: usize, depth: u32) -> f32 {
    let marks = batch.past.marks[i];
    let knows_all = marks & marks::DIFFUSE != 0;
    if marks & marks::TAKEN != 0 && (knows_all || frame.sends_caustics(end.light)) {
        return 0.0;
    }
    share_of_hit(frame, end, batch, i, depth) * left_by_photons(frame, end, batch, i)
}

/// Returns the share of a lamp's light that photons leave to ray `i`, which ends on it.
fn left_by_photons(frame: &FrameScene, end: End, batch: &Batch, i: usize) -> f32 {
    let Past { from, marks, rough, .. } = &batch.past;
    let Some(emission) = frame.emission.as_ref().filter(|_| rough.is_kept) else { return 1.0 };
    if marks[i] & marks::SHARP == 0 || rough.rival[i] == 0.0 {
        return 1.0;
    }
    let (point, time) = (from.get(i) + end.way, batch.labels.time[i]);
    let toward = -batch.rays.direction(i);
    let density = emission.density(&frame.lights, end.light, time, point, toward);
    rough.rival[i] / (rough.rival[i] + density)
}

/// Like [`share`], among techniques that start at the camera.
fn share_of_hit(frame: &FrameScene, end: End, batch: &Batch, i: usize, depth: u32) -> f32 {
    let number = end.light;
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
    let chance = match number.checked_sub(frame.first_chosen) {
        None => 1.0,
        Some(chosen) => {
            frame.light_tree.chance(chosen, batch.past.from.get(i), batch.past.normal[i])
        }
    };
    let by_light = rays * chance * end.density;
    frame.techniques.hit(is_diffuse, density, by_light)
}
