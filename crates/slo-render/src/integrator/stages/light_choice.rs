//! Choice of a light for each hit, if a hit asks only one of many.

use slo_accel::Lanewise;
use slo_accel::math::columns::{BATCH, Column, lanes};

use super::points::Points;
use crate::frame::FrameScene;
use crate::integrator::work::Job;
use crate::shading::{Lamp, WithLamp};

/// A light for each hit, chosen at random in proportion to the light expected from it, in columns.
#[derive(Debug)]
pub(super) struct LightChoice {
    light: Column<u32>,
    /// Weight of the chosen light, relative to a uniform choice.
    times: Column<f32>,
    /// Light expected from all lights.
    total: Column<f32>,
    /// Sum of the light expected from the lights visited so far.
    below: Column<f32>,
    /// Light expected from the chosen light.
    kept: Column<f32>,
    /// Sum of the light expected from the lights before the chosen one.
    before: Column<f32>,
    /// The random number, rescaled after the choice to be uniform again.
    rest: Column<f32>,
}

impl Default for LightChoice {
    fn default() -> Self {
        let zeros = [0.0; BATCH];
        Self {
            light: [0; BATCH],
            times: zeros,
            total: zeros,
            below: zeros,
            kept: zeros,
            before: zeros,
            rest: zeros,
        }
    }
}

impl LightChoice {
    /// Chooses a light for each point by a random number, in the order of the lights, so that
    /// stratified numbers give stratified choices. Returns `None`, without a choice, if the work is
    /// given up.
    pub(super) fn choose(&mut self, job: &Job<'_>, points: &Points, u: &Column<f32>) -> Option<()> {
        let frame = job.frame;
        let expect = Expect { points, through: frame.receives_through(), alike: !frame.clever };
        self.total = [0.0; BATCH];
        for light in frame.lights.iter() {
            job.goes_on()?;
            light.with(AddUp { frame, expect, total: &mut self.total });
        }
        self.below = [0.0; BATCH];
        self.kept = [0.0; BATCH];
        self.light = [0; BATCH];
        for (number, light) in (0..).zip(frame.lights.iter()) {
            job.goes_on()?;
            light.with(Pass { frame, expect, number, u, to: self });
        }
        let (len, count) = (points.surfaces.len, frame.lights.len() as f32);
        frame.isa.run(Finish { len, count, u, to: self });
        Some(())
    }

    /// Returns the index of the light of each point.
    pub(super) fn light(&self) -> &Column<u32> {
        &self.light
    }

    /// Returns the weight of the light of each point, relative to a uniform choice.
    pub(super) fn times(&self) -> &Column<f32> {
        &self.times
    }

    /// Returns the random numbers rescaled after the choice: uniform again, and nearly independent
    /// of it.
    pub(super) fn rest(&self) -> &Column<f32> {
        &self.rest
    }
}

/// Estimates the light that points receive from a light.
#[derive(Clone, Copy)]
struct Expect<'a> {
    points: &'a Points,
    /// See [`Lamp::expected`].
    through: bool,
    /// Whether all lights have the same probability.
    alike: bool,
}

impl Expect<'_> {
    #[inline(always)]
    fn of(&self, light: &impl Lamp, i: usize) -> f32 {
        let surfaces = &self.points.surfaces;
        let normals = [surfaces.n_shade.get(i), surfaces.n_geo.get(i)];
        let expected = light.expected(surfaces.point.get(i), normals, self.through);
        if self.alike { 1.0 } else { expected }
    }
}

struct AddUp<'a> {
    frame: &'a FrameScene,
    expect: Expect<'a>,
    total: &'a mut Column<f32>,
}

impl WithLamp for AddUp<'_> {
    type Output = ();

    fn run<L: Lamp>(self, lamp: L) {
        self.frame.isa.run(OfLamp { lamp, work: self });
    }
}

/// Moves the choice to this light if the random number is not below the end of the previous light's
/// interval.
struct Pass<'a> {
    frame: &'a FrameScene,
    expect: Expect<'a>,
    number: u32,
    u: &'a Column<f32>,
    to: &'a mut LightChoice,
}

impl WithLamp for Pass<'_> {
    type Output = ();

    fn run<L: Lamp>(self, lamp: L) {
        self.frame.isa.run(OfLamp { lamp, work: self });
    }
}

/// Work for a light of a known kind. The light is a copy, which cannot alias a column.
struct OfLamp<L, W> {
    lamp: L,
    work: W,
}

impl<L: Lamp> Lanewise for OfLamp<L, AddUp<'_>> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { lamp, work: AddUp { expect, total, .. } } = self;
        for i in lanes(expect.points.surfaces.len) {
            total[i] += expect.of(&lamp, i);
        }
    }
}

impl<L: Lamp> Lanewise for OfLamp<L, Pass<'_>> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { lamp, work: Pass { expect, number, u, to, .. } } = self;
        for i in lanes(expect.points.surfaces.len) {
            let expected = expect.of(&lamp, i);
            let passes = u[i] * to.total[i] >= to.below[i] && expected > 0.0;
            to.light[i] = if passes { number } else { to.light[i] };
            to.kept[i] = if passes { expected } else { to.kept[i] };
            to.before[i] = if passes { to.below[i] } else { to.before[i] };
            to.below[i] += expected;
        }
    }
}

struct Finish<'a> {
    len: usize,
    count: f32,
    u: &'a Column<f32>,
    to: &'a mut LightChoice,
}

impl Lanewise for Finish<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { len, count, u, to } = self;
        for i in lanes(len) {
            let times = to.total[i] / (to.kept[i] * count);
            to.times[i] = if to.kept[i] > 0.0 { times } else { 0.0 };
            // Rounding may make it negative.
            to.rest[i] = ((u[i] * to.total[i] - to.before[i]) / to.kept[i]).max(0.0);
        }
    }
}
