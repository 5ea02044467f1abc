//! Which light each hit asks, where one is asked for all.

use super::points::Points;
use crate::frame::FrameScene;
use crate::shading::AnyLight as Light;
use slo_accel::Lanewise;
use slo_accel::math::columns::{BATCH, Column, lanes};

/// A light for each hit, chosen at random by what is expected of it there, in columns.
#[derive(Debug)]
pub(super) struct LightChoice {
    light: Column<u32>,
    /// What the chosen one counts, over what it counts where all are equally likely.
    times: Column<f32>,
    /// What is expected of all lights.
    total: Column<f32>,
    /// What is expected of the lights up to this one.
    below: Column<f32>,
    /// What is expected of the chosen one.
    kept: Column<f32>,
    /// What is expected of those before the chosen one.
    before: Column<f32>,
    /// What the choice left of its number: uniform again.
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
    /// Chooses for all points, by a random number each: in the order of the lights, so that where
    /// numbers are stratified the choices are. `None`, without a choice, if told to give up.
    pub(super) fn choose(
        &mut self,
        frame: &FrameScene,
        points: &Points,
        u: &Column<f32>,
        gives_up: &dyn Fn() -> bool,
    ) -> Option<()> {
        let expect = Expect { points, through: frame.receives_through(), alike: !frame.clever };
        self.total = [0.0; BATCH];
        for light in &frame.lights {
            if gives_up() {
                return None;
            }
            frame.isa.run(AddUp { expect, light, total: &mut self.total });
        }
        self.below = [0.0; BATCH];
        self.kept = [0.0; BATCH];
        self.light = [0; BATCH];
        for (number, light) in (0..).zip(&frame.lights) {
            if gives_up() {
                return None;
            }
            frame.isa.run(Pass { expect, light, number, u, to: self });
        }
        let (len, count) = (points.surfaces.len, frame.lights.len() as f32);
        frame.isa.run(Finish { len, count, u, to: self });
        Some(())
    }

    /// The light of point `i`, and what it counts over what it counts where all are equally likely.
    #[inline(always)]
    pub(super) fn of(&self, lights: &[Light], i: usize) -> (Light, f32) {
        (lights[self.light[i] as usize], self.times[i])
    }

    /// What the choices left of their numbers: uniform again, and as good as independent of them.
    pub(super) fn rest(&self) -> &Column<f32> {
        &self.rest
    }
}

/// What is expected of lights, where.
#[derive(Clone, Copy)]
struct Expect<'a> {
    points: &'a Points,
    /// See [`Light::expected`].
    through: bool,
    /// Whether it is the same of all.
    alike: bool,
}

impl Expect<'_> {
    #[inline(always)]
    fn of(&self, light: &Light, i: usize) -> f32 {
        let surfaces = &self.points.surfaces;
        let normals = [surfaces.n_shade.get(i), surfaces.n_geo.get(i)];
        let expected = light.expected(surfaces.point.get(i), normals, self.through);
        if self.alike { 1.0 } else { expected }
    }
}

struct AddUp<'a> {
    expect: Expect<'a>,
    light: &'a Light,
    total: &'a mut Column<f32>,
}

impl Lanewise for AddUp<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { expect, light, total } = self;
        // A copy, which no column can overlap.
        let light = *light;
        for i in lanes(expect.points.surfaces.len) {
            total[i] += expect.of(&light, i);
        }
    }
}

/// Passes on from the light before to this one, where the number is not below that one's end.
struct Pass<'a> {
    expect: Expect<'a>,
    light: &'a Light,
    number: u32,
    u: &'a Column<f32>,
    to: &'a mut LightChoice,
}

impl Lanewise for Pass<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { expect, light, number, u, to } = self;
        let light = *light;
        for i in lanes(expect.points.surfaces.len) {
            let expected = expect.of(&light, i);
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
            // Rounding may take it below 0.
            to.rest[i] = ((u[i] * to.total[i] - to.before[i]) / to.kept[i]).max(0.0);
        }
    }
}
