//! Rays that gather the light of hemispheres, about points whose irradiance is wanted.

use glam::Vec3;
use slo_accel::math::columns::BATCH;

use super::hits::Hits;
use crate::frame::FrameScene;
use crate::integrator::batch::{Batch, marks};
use crate::photons::Grid;
use crate::sampling::{Hit, PixelSeed, Purpose, Use, next_path};
use crate::shading::light::receiver;
use crate::shading::lobe::pair;

/// A point whose hemisphere is gathered.
#[derive(Clone, Copy, Debug)]
pub struct Probe {
    /// On the surface.
    pub point: Vec3,
    /// Where its rays start.
    pub origin: Vec3,
    /// Unit normal.
    pub normal: Vec3,
    /// Time of the shutter.
    pub time: f32,
    /// Width of a pixel there.
    pub width: f32,
    /// Names its random numbers.
    pub seed: PixelSeed,
}

/// One round of rays about some points; the slot of each ray is its number.
#[derive(Debug, Default)]
pub(in crate::integrator) struct Hemispheres {
    probes: Vec<Probe>,
    grid: Option<Grid>,
    round: u32,
    next: u32,
    /// For each ray, the distance of what it hit.
    pub(in crate::integrator) distances: Vec<f32>,
}

impl Hemispheres {
    /// The rays count as those of paths after so many bounces.
    pub(in crate::integrator) const DEPTH: u32 = 1;

    /// Begins a round.
    pub(in crate::integrator) fn restart(&mut self, probes: &[Probe], grid: Grid, round: u32) {
        self.probes.clear();
        self.probes.extend_from_slice(probes);
        (self.grid, self.round, self.next) = (Some(grid), round, 0);
        self.distances.clear();
        self.distances.resize(probes.len() * grid.rays() as usize, f32::INFINITY);
    }

    /// Creates the next rays. Returns whether there were any.
    pub(in crate::integrator) fn fill(&mut self, frame: &FrameScene, batch: &mut Batch) -> bool {
        let Some(grid) = self.grid else { return false };
        let all = self.distances.len() as u32;
        batch.rays.set_len(0);
        let mut len = 0;
        while self.next < all && len < BATCH {
            let (number, ray) = ((self.next / grid.rays()) as usize, self.next % grid.rays());
            let probe = self.probes[number];
            let index = self.round.wrapping_mul(grid.rays()).wrapping_add(ray);
            let hit = Hit { path: PATH, depth: 0, split: true };
            let u = frame.sampler.point2(probe.seed.key(hit, Purpose::Heading), index);
            let (local, (x, y)) = (grid.direction(ray, u), pair(probe.normal));
            let direction = x * local.x + y * local.y + probe.normal * local.z;
            batch.rays.push(probe.origin, direction, f32::INFINITY);
            batch.weight.set(len, Vec3::ONE);
            batch.density[len] = 0.0;
            batch.labels.time[len] = probe.time;
            batch.labels.slot[len] = self.next;
            batch.labels.path[len] = next_path(PATH, Use::from(Purpose::Continuation));
            batch.labels.index[len] = index;
            batch.past.from.set(len, probe.point);
            batch.past.normal[len] = receiver::pack(probe.normal);
            batch.past.marks[len] = marks::DIFFUSE | marks::TAKEN;
            self.next += 1;
            len += 1;
        }
        batch.past.rough.is_kept = false;
        len > 0
    }

    /// Notes how far the rays of a batch went, which may have passed through something before.
    pub(in crate::integrator) fn note(&mut self, batch: &Batch, hits: &Hits) {
        for i in 0..batch.len() {
            let end = batch.rays.origin(i) + batch.rays.direction(i) * hits.found.hits.t[i];
            let distance = (end - batch.past.from.get(i)).length();
            self.distances[batch.labels.slot[i] as usize] = distance;
        }
    }
}

/// Tells paths of hemispheres from those of the camera.
const PATH: u32 = 0x6a7e_5eed;
