//! How rays are counted, and what those of each pixel cost.

use std::sync::atomic::{AtomicU64, Ordering};

use slo_accel::math::Bounds;
use slo_accel::study::Counts;

/// How the rays of a frame are counted.
#[derive(Debug)]
pub(crate) struct RayCounting {
    /// Boxes of the instances that are kept one by one.
    pub(super) boxes: Vec<Bounds>,
    /// What the rays of each pixel take, if that is counted too.
    pub(crate) map: Option<CostMap>,
}

/// What is counted for each pixel of a frame.
#[derive(Debug)]
pub(crate) struct CostMap {
    width: u32,
    /// Steps and tests of all rays of a pixel, row by row.
    costs: Vec<[AtomicU64; 2]>,
}

impl CostMap {
    /// A map of pixels that cost nothing; `None` if there is no memory for it.
    pub(super) fn new(width: u32, height: u32) -> Option<Self> {
        let pixels = width as usize * height as usize;
        let mut costs = Vec::new();
        costs.try_reserve_exact(pixels).ok()?;
        costs.extend((0..pixels).map(|_| [AtomicU64::new(0), AtomicU64::new(0)]));
        Some(Self { width, costs })
    }

    /// Adds what a ray of a pixel took.
    pub(crate) fn add(&self, [x, y]: [u32; 2], counts: &Counts) {
        if let Some([steps, tests]) = self.costs.get(y as usize * self.width as usize + x as usize)
        {
            steps.fetch_add(counts.steps, Ordering::Relaxed);
            tests.fetch_add(counts.tests, Ordering::Relaxed);
        }
    }

    /// Steps and tests of each pixel, row by row.
    pub(super) fn costs(&self) -> Vec<[u64; 2]> {
        let load = |[steps, tests]: &[AtomicU64; 2]| {
            [steps.load(Ordering::Relaxed), tests.load(Ordering::Relaxed)]
        };
        self.costs.iter().map(load).collect()
    }
}
