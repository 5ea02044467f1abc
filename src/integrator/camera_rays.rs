//! The camera rays of a batch.

use super::Work;
use super::queue::Batch;
use crate::accel::Lanewise;
use crate::camera::Camera;
use crate::frame::FrameScene;
use crate::math::columns::{BATCH, Column, Vec3s};
use crate::sampling::PixelSeed;
use crate::sampling::batch::{CameraSamples, Digits, Run};

/// What is left of some work, and the working memory of making its camera rays.
#[derive(Debug)]
pub(super) struct CameraRays {
    samples: CameraSamples,
    runs: Vec<Run>,
    x: Column<u32>,
    y: Column<u32>,
    origin: Vec3s,
    direction: Vec3s,
}

impl Default for CameraRays {
    fn default() -> Self {
        Self {
            samples: CameraSamples::default(),
            runs: Vec::new(),
            x: [0; BATCH],
            y: [0; BATCH],
            origin: Vec3s::default(),
            direction: Vec3s::default(),
        }
    }
}

/// How far the camera rays of some work are made.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Place {
    /// Entry of the work.
    work: usize,
    /// Samples of it that are made already.
    samples: u32,
}

impl CameraRays {
    /// Fills a batch with the next camera rays of the work; none are left when it comes out empty.
    pub(super) fn fill(
        &mut self,
        frame: &FrameScene,
        work: &[Work],
        seeds: &[PixelSeed],
        place: &mut Place,
        digits: &mut Digits,
        batch: &mut Batch,
    ) {
        self.runs.clear();
        let mut len = 0;
        while let Some(w) = work.get(place.work).filter(|_| len < BATCH) {
            let count = (w.count - place.samples).min((BATCH - len) as u32);
            let first = w.first + place.samples;
            self.runs.push(Run { seed: seeds[place.work], first, count });
            let lanes = len..len + count as usize;
            self.x[lanes.clone()].fill(w.x);
            self.y[lanes.clone()].fill(w.y);
            batch.labels.slot[lanes.clone()].fill(place.work as u32);
            for (index, lane) in (first..).zip(&mut batch.labels.index[lanes]) {
                *lane = index;
            }
            len += count as usize;
            place.samples += count;
            if place.samples == w.count {
                *place = Place { work: place.work + 1, samples: 0 };
            }
        }
        self.samples.take(&frame.sampler, frame.isa, &self.runs, digits);
        frame.isa.run(Expose { camera: &frame.camera, rays: self, len });
        self.put(len, batch);
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
        batch.labels.path[..len].fill(0);
        for weight in [&mut batch.weight.x, &mut batch.weight.y, &mut batch.weight.z] {
            weight[..len].fill(1.0);
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
