//! The queues of one thread, and the order in which they are worked off.

use glam::Vec3;

use super::queue::{BATCH, QueuedRay, RayQueue, ShadowQueue, ShadowRay};
use super::shade::HitPoint;
use super::{SampleSum, Statistics, Work};
use crate::accel::{Coherence, NO_HIT};
use crate::film::Fixed;
use crate::frame::{FrameScene, Hit, Look, WorldHits, WorldScratch};
use crate::sampling::PixelSeed;
use crate::scene::ShadowMode;

/// Working memory of one thread: allocated once, used for tile after tile.
#[derive(Debug, Default)]
pub struct Wave {
    /// Rays by the number of bounces behind them.
    bounces: Vec<RayQueue>,
    /// Rays to lights: from primary hits, whose neighbours are alike, and from all others.
    pub(super) shadows: [ShadowQueue; 2],
    /// Seed of the pixel of each camera sample.
    pub(super) seeds: Vec<PixelSeed>,
    pub(super) counts: Statistics,
    sums: Vec<SampleSum>,
    batch: RayQueue,
    shadow_batch: ShadowQueue,
    found: WorldHits,
    blocked: Vec<bool>,
    pub(super) points: Vec<HitPoint>,
    scratch: WorldScratch,
}

impl Wave {
    /// Traces camera samples to the end: `sums` has one entry per sample, in the order of `work`.
    pub fn trace(&mut self, frame: &FrameScene, work: &[Work]) -> (&[SampleSum], Statistics) {
        self.counts = Statistics::default();
        self.sums.clear();
        self.seeds.clear();
        self.bounces.resize_with(self.bounces.len().max(1), RayQueue::default);
        let mut samples =
            work.iter().flat_map(|w| (w.first..w.first + w.count).map(move |i| (w, i)));
        while self.add_camera_rays(frame, &mut samples) {
            self.work_off(frame, BATCH);
        }
        self.work_off(frame, 1);
        (&self.sums, self.counts)
    }

    /// Queues the next camera samples, a batch at most. False where none is left.
    fn add_camera_rays<'a>(
        &mut self,
        frame: &FrameScene,
        samples: &mut impl Iterator<Item = (&'a Work, u32)>,
    ) -> bool {
        let before = self.sums.len();
        for (work, index) in samples.take(BATCH) {
            let seed = frame.sampler.pixel(work.x, work.y);
            let sample = frame.sampler.camera(seed, index);
            let (origin, direction) = frame.camera.ray(work.x, work.y, &sample);
            self.bounces[0].push(QueuedRay {
                origin,
                direction,
                time: sample.time,
                weight: Vec3::ONE,
                slot: self.sums.len() as u32,
                path: 0,
                index,
            });
            self.seeds.push(seed);
            self.sums.push(SampleSum::default());
        }
        self.counts.camera_rays += (self.sums.len() - before) as u64;
        self.sums.len() > before
    }

    /// Traces batches until no queue holds `least` rays or more.
    ///
    /// While more rays are to come the deepest full queue goes first, which bounds what waits; at
    /// the end, where all are below a batch, the shallowest goes first, since it fills the others.
    fn work_off(&mut self, frame: &FrameScene, least: usize) {
        loop {
            let full = |queue: &RayQueue| queue.len() >= BATCH;
            let waiting = |queue: &RayQueue| queue.len() >= least;
            let depth = self.bounces.iter().rposition(full);
            if let Some(kind) = self.shadows.iter().position(|queue| queue.len() >= BATCH) {
                self.trace_shadows(frame, kind);
            } else if let Some(depth) = depth.or_else(|| self.bounces.iter().position(waiting)) {
                self.trace_bounces(frame, depth);
            } else if let Some(kind) = self.shadows.iter().position(|q| q.len() >= least) {
                self.trace_shadows(frame, kind);
            } else {
                return;
            }
        }
    }

    fn trace_bounces(&mut self, frame: &FrameScene, depth: usize) {
        let mut batch = std::mem::take(&mut self.batch);
        self.bounces[depth].take_batch(&mut batch);
        if depth > 0 {
            self.counts.bounce_rays += batch.len() as u64;
        }
        let coherence = if depth == 0 { Coherence::Coherent } else { Coherence::Incoherent };
        frame.world.intersect(
            &batch.rays,
            &batch.time,
            coherence,
            &mut self.found,
            &mut self.scratch,
        );
        self.points.clear();
        for i in 0..batch.len() {
            self.add_hit(frame, &batch, i);
        }
        self.batch = batch;
        self.shade(frame, depth as u32);
    }

    /// Adds what ray `i` brings by itself, and notes its hit for shading.
    fn add_hit(&mut self, frame: &FrameScene, batch: &RayQueue, i: usize) {
        let (slot, weight) = (batch.slot[i], batch.weight[i]);
        if self.found.hits.primitive[i] == NO_HIT {
            self.add(slot, weight * Vec3::from(frame.settings.background));
            return;
        }
        let hit = self.hit(&batch.rays, &batch.time, i);
        match frame.look(&hit) {
            Look::Light(color) => self.add(slot, weight * color),
            Look::Material(material) => self.points.push(HitPoint {
                surface: frame.surface(&hit),
                material,
                direction: hit.direction,
                time: hit.time,
                weight,
                slot,
                path: batch.path[i],
                index: batch.index[i],
            }),
        }
    }

    fn hit(&self, rays: &crate::accel::Rays, time: &[f32], i: usize) -> Hit {
        Hit {
            origin: rays.origin(i),
            direction: rays.direction(i),
            time: time[i],
            t: self.found.hits.t[i],
            uv: [self.found.hits.u[i], self.found.hits.v[i]],
            primitive: self.found.hits.primitive[i],
            instance: self.found.instance[i],
        }
    }

    fn trace_shadows(&mut self, frame: &FrameScene, kind: usize) {
        let mut batch = std::mem::take(&mut self.shadow_batch);
        self.shadows[kind].take_batch(&mut batch);
        self.counts.shadow_rays += batch.len() as u64;
        match frame.settings.shadow {
            ShadowMode::Opaque => self.trace_opaque_shadows(frame, &batch, kind),
            ShadowMode::Transparent => self.trace_transparent_shadows(frame, &batch, kind),
        }
        self.shadow_batch = batch;
    }

    fn trace_opaque_shadows(&mut self, frame: &FrameScene, batch: &ShadowQueue, kind: usize) {
        let coherence = if kind == 0 { Coherence::Coherent } else { Coherence::Incoherent };
        let (blocked, scratch) = (&mut self.blocked, &mut self.scratch);
        frame.world.occluded(&batch.rays, &batch.time, coherence, blocked, scratch);
        for i in 0..batch.len() {
            if !self.blocked[i] {
                self.add(batch.slot[i], batch.light[i]);
            }
        }
    }

    /// A ray that meets a refractive object goes on behind it, weaker.
    fn trace_transparent_shadows(&mut self, frame: &FrameScene, batch: &ShadowQueue, kind: usize) {
        let coherence = if kind == 0 { Coherence::Coherent } else { Coherence::Incoherent };
        let (found, scratch) = (&mut self.found, &mut self.scratch);
        frame.world.intersect(&batch.rays, &batch.time, coherence, found, scratch);
        for i in 0..batch.len() {
            let (slot, light) = (batch.slot[i], batch.light[i]);
            if self.found.hits.primitive[i] == NO_HIT {
                self.add(slot, light);
                continue;
            }
            let hit = self.hit(&batch.rays, &batch.time, i);
            let Some(passed) = frame.light_passed(&hit) else { continue };
            let origin = frame.surface(&hit).leave(hit.direction);
            // The rest of the way ends where it ended before.
            let target = hit.origin + hit.direction * batch.rays.t_max[i];
            self.shadows[kind].push(ShadowRay {
                origin,
                direction: target - origin,
                t_max: 1.0,
                time: hit.time,
                light: light * passed,
                slot,
            });
        }
    }

    /// The queue of rays with `depth` bounces behind them.
    pub(super) fn bounces_at(&mut self, depth: usize) -> &mut RayQueue {
        if self.bounces.len() <= depth {
            self.bounces.resize_with(depth + 1, RayQueue::default);
        }
        &mut self.bounces[depth]
    }

    /// Adds radiance to a camera sample.
    #[inline]
    pub(super) fn add(&mut self, slot: u32, radiance: Vec3) {
        let sum = &mut self.sums[slot as usize];
        for (channel, value) in sum.iter_mut().zip(radiance.to_array()) {
            match Fixed::new(value) {
                Some(value) => *channel += value,
                None => self.counts.refused_contributions += 1,
            }
        }
    }
}
