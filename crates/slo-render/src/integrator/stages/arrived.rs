//! Light of paths that end on a lamp or in the sky.

use glam::Vec3;
use slo_accel::math::columns::{BATCH, Column, Vec3s};

use super::hits::Hits;
use crate::frame::{FrameScene, Look};
use crate::integrator::batch::{Batch, Past, marks};
use crate::integrator::branching::rays_to;
use crate::shading::light::{Sampled, Samples};

/// Light of the rays that are not shaded.
#[derive(Debug)]
pub(in crate::integrator) struct Arrived {
    /// The rays in their batch.
    ray: Column<u32>,
    /// The entries whose rays hit nothing.
    escaped: Vec<u16>,
    skies: Skies,
    /// Weighted radiance.
    pub(in crate::integrator) light: Vec3s,
    pub(in crate::integrator) slot: Column<u32>,
    pub(in crate::integrator) len: usize,
}

impl Default for Arrived {
    fn default() -> Self {
        Self {
            ray: [0; BATCH],
            escaped: Vec::new(),
            skies: Skies::default(),
            light: Vec3s::default(),
            slot: [0; BATCH],
            len: 0,
        }
    }
}

/// Light of skies, for the rays that hit nothing.
#[derive(Debug)]
struct Skies {
    time: Column<f32>,
    /// Where the rays left the last surface.
    from: Vec3s,
    /// What one sky shows.
    found: Samples,
    /// The light of all skies.
    sum: Vec3s,
}

impl Default for Skies {
    fn default() -> Self {
        Self {
            time: [0.0; BATCH],
            from: Vec3s::default(),
            found: Samples::default(),
            sum: Vec3s::default(),
        }
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
        self.escaped.clear();
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
                    self.escaped.push(self.len as u16);
                    let background = Vec3::from(frame.settings.background);
                    (if part > 0 { Vec3::ZERO } else { background }, skies.first().copied())
                }
            };
            let group = first.filter(|_| stride > 0).map_or(0, |number| frame.group_of(number));
            self.light.set(self.len, light);
            self.slot[self.len] = batch.labels.slot[i] + group * stride;
            self.ray[self.len] = i as u32;
            self.len += 1;
        }
        if !skies.is_empty() {
            self.add_skies(frame, skies, batch, depth);
        }
        for k in 0..self.len.min(BATCH) {
            self.light.set(k, batch.weight.get(self.ray[k] as usize) * self.light.get(k));
        }
    }

    /// Adds the light of skies to that of the rays that hit nothing.
    fn add_skies(&mut self, frame: &FrameScene, numbers: &[u32], batch: &Batch, depth: u32) {
        let Self { ray, escaped, skies, light, .. } = self;
        let rays = || escaped.iter().map(|k| ray[usize::from(*k)] as usize);
        for (k, i) in rays().enumerate().take(BATCH) {
            skies.time[k] = batch.labels.time[i];
            skies.from.set(k, batch.past.from.get(i));
            skies.found.way.set(k, batch.rays.direction(i));
            skies.sum.set(k, Vec3::ZERO);
        }
        for &number in numbers {
            if depth == 0 && frame.is_hidden(number) {
                continue;
            }
            let Skies { time, from, found, sum } = &mut *skies;
            let hits = (&*time, &*from, escaped.len());
            frame.lights.found_each(frame.isa, number, hits, found);
            for (k, i) in rays().enumerate().take(BATCH) {
                let Sampled { way, radiance, density } = found.get(k);
                let end = End { light: number, way, density };
                let is_shared = depth > 0 && radiance != Vec3::ZERO;
                let share = if is_shared { share(frame, end, batch, i, depth) } else { 1.0 };
                sum.set(k, sum.get(k) + radiance * share);
            }
        }
        for (k, entry) in escaped.iter().map(|entry| usize::from(*entry)).enumerate().take(BATCH) {
            light.set(entry, light.get(entry) + skies.sum.get(k));
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
