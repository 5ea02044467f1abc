//! Batches of weighted rays -> radiance. Knows no files and no threads.
//!
//! A sample of the thesis's lighting model is a sum over a tree of rays. Every ray carries what its
//! hit is worth to the picture, so the tree needs no way back: a hit adds its own light and puts
//! the rays that it sends out into queues, which are worked off a batch at a time, until none is
//! left. Whatever the order, the exact sums come out the same.

mod bounces;
mod camera_rays;
mod chosen;
mod features;
mod light_choice;
mod lights;
mod points;
mod queue;
mod roulette;
mod sums;
mod wave;

use slo_picture::film::{Features, Fixed};

pub use wave::Wave;

/// Samples `first..first + count` of one pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Work {
    /// Column.
    pub x: u32,
    /// Row, from the top.
    pub y: u32,
    /// First sample.
    pub first: u32,
    /// How many.
    pub count: u32,
}

/// Sum of the radiances of camera samples.
pub type SampleSum = [Fixed; 3];

/// What came of camera samples, for each entry of the work, in its order.
#[derive(Clone, Copy, Debug)]
pub struct Traced<'a> {
    /// Exact sums of light.
    pub sums: &'a [SampleSum],
    /// Exact sums of what was seen of surfaces; empty where nobody asked.
    pub features: &'a [Features],
    /// What was traced.
    pub statistics: Statistics,
}

/// What was traced: counts for the log, never part of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Camera samples taken.
    pub camera_rays: u64,
    /// Rays toward lights.
    pub shadow_rays: u64,
    /// Reflected and refracted rays.
    pub bounce_rays: u64,
    /// Contributions that were not finite or out of the film's range, left out of the sums.
    pub refused_contributions: u64,
}

impl std::ops::AddAssign for Statistics {
    fn add_assign(&mut self, other: Self) {
        self.camera_rays += other.camera_rays;
        self.shadow_rays += other.shadow_rays;
        self.bounce_rays += other.bounce_rays;
        self.refused_contributions += other.refused_contributions;
    }
}
