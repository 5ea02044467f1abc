//! The camera rays of a batch, or rays that hit texels.

use std::ops::Range;

use glam::Vec3;
use slo_accel::Lanewise;
use slo_accel::math::columns::{BATCH, Column, Vec3s};

use crate::camera::Camera;
use crate::frame::{Baked, FrameScene, TexelPoint};
use crate::integrator::batch::Batch;
use crate::integrator::work::{Job, Work};
use crate::sampling::PixelSeed;
use crate::sampling::batch::{CameraNames, CameraSamples};

/// Progress in creating the camera rays of some work, and working memory.
#[derive(Debug)]
pub(in crate::integrator) struct CameraRays {
    place: Place,
    samples: CameraSamples,
    /// Seeds of the pixels, as words.
    seed: Column<u32>,
    x: Column<u32>,
    y: Column<u32>,
    origin: Vec3s,
    direction: Vec3s,
    /// What each ray hits if the pixels are texels; otherwise empty.
    points: Vec<Option<TexelPoint>>,
}

impl Default for CameraRays {
    fn default() -> Self {
        Self {
            place: Place::default(),
            samples: CameraSamples::default(),
            seed: [0; BATCH],
            x: [0; BATCH],
            y: [0; BATCH],
            origin: Vec3s::default(),
            direction: Vec3s::default(),
            points: Vec::new(),
        }
    }
}

/// Progress in creating the camera rays of some work.
#[derive(Clone, Copy, Debug, Default)]
struct Place {
    /// Index of the current entry of the work.
    work: usize,
    /// Number of its samples that were created.
    samples: u32,
}

impl CameraRays {
    /// Starts again at the first sample of some work.
    pub(in crate::integrator) fn restart(&mut self) {
        self.place = Place::default();
    }

    /// Fills a batch with the next camera rays of the work, at most `most`. The batch stays empty
    /// when all were created.
    pub(in crate::integrator) fn fill(
        &mut self,
        job: &Job<'_>,
        seeds: &[PixelSeed],
        most: usize,
        batch: &mut Batch,
    ) {
        let (frame, most) = (job.frame, most.min(BATCH));
        let list = List { work: job.work, seeds, most, rays: self, batch };
        let (len, end) = frame.isa.run(list);
        let lens = frame.camera.has_lens();
        let names = CameraNames { seed: &self.seed, index: &batch.labels.index, end, lens, len };
        self.samples.take(&frame.sampler, frame.isa, &names);
        self.points.clear();
        match &frame.baked {
            None => frame.isa.run(Expose { camera: &frame.camera, rays: self, len }),
            Some(baked) => self.look_at_texels(frame, baked, len),
        }
        self.put(len, batch);
        let rough = &mut batch.past.rough;
        rough.is_kept = frame.emission.is_some();
        if rough.is_kept {
            rough.rival[..len].fill(0.0);
            rough.width[..len].fill(0.0);
            rough.spread[..len].fill(frame.camera.pixel_angle());
        }
    }

    /// Returns what each ray hits if the pixels are texels.
    pub(super) fn points(&self) -> &[Option<TexelPoint>] {
        &self.points
    }

    /// Creates rays that hit texels straight on, from so far away that a pixel of the camera is as wide
    /// as a texel. Texels that are not on the surface have none.
    fn look_at_texels(&mut self, frame: &FrameScene, baked: &Baked, len: usize) {
        for i in 0..len {
            let (sample, place) = (self.samples.get(i), [self.x[i], self.y[i]]);
            let found = frame.texel_point(&baked.texels, place, sample.pixel, sample.time);
            let [origin, direction] = found.map_or([Vec3::ZERO, Vec3::Z], |found| {
                let distance = found.width / frame.camera.pixel_angle();
                [found.point + found.normal * distance, -found.normal]
            });
            self.origin.set(i, origin);
            self.direction.set(i, direction);
            self.points.push(found);
        }
    }

    fn put(&self, len: usize, batch: &mut Batch) {
        batch.rays.set_len(len);
        for (to, from) in batch.rays.origin.iter_mut().zip(self.origin.columns()) {
            to[..len].copy_from_slice(&from[..len]);
        }
        for (to, from) in batch.rays.direction.iter_mut().zip(self.direction.columns()) {
            to[..len].copy_from_slice(&from[..len]);
        }
        batch.rays.t_max[..len].fill(f32::INFINITY);
        batch.labels.time.copy_from_slice(self.samples.time());
        batch.density[..len].fill(0.0);
        batch.past.marks[..len].fill(0);
        batch.labels.path[..len].fill(0);
        for weight in [&mut batch.weight.x, &mut batch.weight.y, &mut batch.weight.z] {
            weight[..len].fill(1.0);
        }
        for (i, _) in self.points.iter().enumerate().filter(|(_, point)| point.is_none()) {
            batch.weight.set(i, Vec3::ZERO);
        }
    }
}

/// Lists the next samples of some work, at most `most`. Returns their number, and the highest
/// sample number plus one.
struct List<'a> {
    work: &'a [Work],
    seeds: &'a [PixelSeed],
    most: usize,
    rays: &'a mut CameraRays,
    batch: &'a mut Batch,
}

impl Lanewise for List<'_> {
    type Output = (usize, u32);

    #[inline(always)]
    fn run(self) -> (usize, u32) {
        let Self { work, seeds, most, rays, batch } = self;
        let CameraRays { place, seed, x, y, .. } = rays;
        let (mut len, mut end) = (0, 0);
        while let Some(w) = work.get(place.work).filter(|_| len < most) {
            let count = (w.count - place.samples).min((most - len) as u32);
            let first = w.first + place.samples;
            let lanes = len..len + count as usize;
            put(x, lanes.clone(), |_| w.x);
            put(y, lanes.clone(), |_| w.y);
            put(seed, lanes.clone(), |_| seeds[place.work].word());
            put(&mut batch.labels.slot, lanes.clone(), |_| place.work as u32);
            put(&mut batch.labels.index, lanes, |i| first.wrapping_add(i));
            len += count as usize;
            end = end.max(first.saturating_add(count));
            place.samples += count;
            if place.samples == w.count {
                *place = Place { work: place.work + 1, samples: 0 };
            }
        }
        (len, end)
    }
}

/// Sets the entries `lanes` of a column to `of(0)`, `of(1)` and so on. It may also overwrite
/// entries behind them, which makes it fast for short ranges: most pixels of adaptive pictures take
/// fewer samples than a register holds.
#[inline(always)]
fn put(column: &mut Column<u32>, lanes: Range<usize>, of: impl Fn(u32) -> u32) {
    const REGISTER: usize = 16;
    match column[lanes.start..].first_chunk_mut::<REGISTER>() {
        Some(entries) if lanes.len() <= REGISTER => {
            *entries = std::array::from_fn(|i| of(i as u32));
        }
        _ => {
            for (i, entry) in (0..).zip(&mut column[lanes]) {
                *entry = of(i);
            }
        }
    }
}

struct Expose<'a> {
    camera: &'a Camera,
    rays: &'a mut CameraRays,
    len: usize,
}

impl Lanewise for Expose<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { camera, rays, len } = self;
        let CameraRays { samples, x, y, origin, direction, .. } = rays;
        camera.rays([x, y], samples, [origin, direction], len);
    }
}
