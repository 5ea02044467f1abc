//! Choice of a light for each hit, if a hit asks only one of many.

use slo_accel::Lanewise;
use slo_accel::math::columns::{BATCH, Column, lanes};

use super::points::Points;
use crate::frame::FrameScene;
use crate::integrator::work::Job;
use crate::shading::light::{Choices, receiver};

/// A light for each hit, chosen at random in proportion to the light expected from it, in columns.
#[derive(Debug)]
pub(super) struct LightChoice {
    choices: Choices,
    /// Weight of the chosen light, relative to a uniform choice.
    times: Column<f32>,
    /// Packed normals.
    receiver: Column<u32>,
}

impl Default for LightChoice {
    fn default() -> Self {
        let (times, receiver) = ([0.0; BATCH], [receiver::ANY; BATCH]);
        Self { choices: Choices::default(), times, receiver }
    }
}

impl LightChoice {
    /// Chooses a light for each point by a random number, such that stratified numbers give
    /// stratified choices.
    pub(super) fn choose(&mut self, job: &Job<'_>, points: &Points, u: &Column<f32>) {
        let frame = job.frame;
        let Self { choices, times, receiver } = self;
        let (isa, len, count) = (frame.isa, points.len(), frame.lights.len());
        if frame.clever {
            let through = frame.receives_through();
            isa.run(Receivers { points, through, to: receiver });
            let from = &points.surfaces.point;
            frame.light_tree.choose_all(isa, len, from, receiver, u, choices);
        } else {
            isa.run(Alike { len, count: count as u32, u, to: choices });
        }
        isa.run(Times { frame, len, choices, to: times });
    }

    /// Returns the index of the light of each point.
    pub(super) fn light(&self) -> &Column<u32> {
        &self.choices.light
    }

    /// Returns the weight of the light of each point, relative to a uniform choice; 0 if no light
    /// can reach the point.
    pub(super) fn times(&self) -> &Column<f32> {
        &self.times
    }

    /// Returns the random numbers rescaled after the choice: uniform again, and nearly independent
    /// of it.
    pub(super) fn rest(&self) -> &Column<f32> {
        &self.choices.rest
    }
}

/// Packs the normals, unless light through the surfaces counts.
struct Receivers<'a> {
    points: &'a Points,
    through: bool,
    to: &'a mut Column<u32>,
}

impl Lanewise for Receivers<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { points, through, to } = self;
        for i in lanes(points.surfaces.len) {
            let packed = receiver::pack(points.surfaces.n_geo.get(i));
            to[i] = if through { receiver::ANY } else { packed };
        }
    }
}

/// Chooses among lights that all have the same probability.
struct Alike<'a> {
    len: usize,
    count: u32,
    u: &'a Column<f32>,
    to: &'a mut Choices,
}

impl Lanewise for Alike<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { len, count, u, to } = self;
        let all = count as f32;
        for i in lanes(len) {
            let place = u[i] * all;
            to.light[i] = (place as u32).min(count - 1);
            to.chance[i] = 1.0 / all;
            to.rest[i] = place - to.light[i] as f32;
        }
    }
}

/// Finds the weights.
struct Times<'a> {
    frame: &'a FrameScene,
    len: usize,
    choices: &'a mut Choices,
    to: &'a mut Column<f32>,
}

impl Lanewise for Times<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { frame, len, choices, to } = self;
        let count = frame.lights.len() as u32;
        for i in lanes(len) {
            let is_lit = choices.light[i] < count;
            to[i] = if is_lit { 1.0 / (choices.chance[i] * count as f32) } else { 0.0 };
            // The ray of a point that no light can reach has the weight 0.
            choices.light[i] = choices.light[i].min(count - 1);
        }
    }
}
