//! Counts of what rays take in the structures.
//!
//! Nothing is counted unless a frame is asked to. Rays are then traced a second time, one by one, by
//! [`Structure::count`](slo_accel::Structure::count); what they find the first time is what the picture
//! is made of. All sums are of integers, so threads may add in any order.

use slo_accel::study::{Counts, Totals};

use super::batch::{Batch, marks};
use super::ray_kind::RayKind;
use super::work::{Job, Work};
use crate::frame::{FrameScene, WorldScratch};

/// The kind of ray `i` of a batch of paths after `depth` bounces.
fn kind_of(frame: &FrameScene, batch: &Batch, i: usize, depth: u32) -> RayKind {
    if depth == 0 {
        return RayKind::Camera;
    }
    if !frame.is_physical {
        return RayKind::Specular;
    }
    let mark = batch.past.marks[i];
    if marks::asked(mark) != 0 {
        RayKind::Shadow
    } else if marks::passed(mark) > 0 {
        RayKind::Passing
    } else if mark & marks::SHARP != 0 {
        RayKind::Specular
    } else if mark & marks::DIFFUSE != 0 {
        RayKind::Diffuse
    } else {
        RayKind::Glossy
    }
}

/// The pixels whose rays are counted, by slot.
#[derive(Debug, Default)]
pub(super) struct Tally {
    pixels: Vec<[u32; 2]>,
}

impl Tally {
    /// Begins to count the rays of some work, if the frame asks for it.
    pub(super) fn begin(&mut self, frame: &FrameScene, work: &[Work]) {
        self.pixels.clear();
        if frame.counting.is_some() {
            self.pixels.extend(work.iter().map(|work| [work.x, work.y]));
        }
    }

    /// Stops counting.
    pub(super) fn stop(&mut self) {
        self.pixels.clear();
    }

    pub(super) fn is_on(&self) -> bool {
        !self.pixels.is_empty()
    }

    /// Counts a batch of paths after `depth` bounces.
    #[cold]
    pub(super) fn paths(
        &self,
        job: &Job<'_>,
        batch: &Batch,
        depth: u32,
        scratch: &mut WorldScratch,
        totals: &mut [Totals],
    ) {
        let kind = |i: usize| kind_of(job.frame, batch, i, depth);
        self.count(job, batch, false, kind, scratch, totals);
    }

    /// Counts a batch of connections. Those that pass through what lets light pass look for the first hit,
    /// the others for any.
    #[cold]
    pub(super) fn connections(
        &self,
        job: &Job<'_>,
        batch: &Batch,
        scratch: &mut WorldScratch,
        totals: &mut [Totals],
    ) {
        let any = !job.frame.lets_light_pass();
        self.count(job, batch, any, |_| RayKind::Shadow, scratch, totals);
    }

    /// Stops between two rays if the work is given up: without a hierarchy, a ray may take long.
    fn count(
        &self,
        job: &Job<'_>,
        batch: &Batch,
        any: bool,
        kind: impl Fn(usize) -> RayKind,
        scratch: &mut WorldScratch,
        totals: &mut [Totals],
    ) {
        let frame = job.frame;
        let Some(counting) = &frame.counting else { return };
        for i in 0..batch.len() {
            if job.goes_on().is_none() {
                return;
            }
            let mut counts = Counts::default();
            let time = batch.labels.time[i];
            let t =
                frame.world.count((&batch.rays, time), i, (any, counting), scratch, &mut counts);
            totals[kind(i) as usize].add(counts, t < f32::INFINITY);
            if let Some(map) = &counting.map {
                map.add(self.pixels[batch.labels.slot[i] as usize % self.pixels.len()], &counts);
            }
        }
    }
}
