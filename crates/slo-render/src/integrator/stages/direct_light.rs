//! Rays from the hits of a batch to lights.

use glam::Vec3;
use slo_accel::Lanewise;
use slo_accel::math::columns::{Column, lanes};

use super::light_choice::LightChoice;
use super::lobes::{Lobe, Lobes};
use super::points::Points;
use crate::frame::FrameScene;
use crate::integrator::batch::Sent;
use crate::integrator::branching::{glossy_samples, mean_rays_to, rays_to};
use crate::integrator::chosen::Chosen;
use crate::integrator::roulette::{least_weight, roulette};
use crate::integrator::work::Job;
use crate::sampling::Purpose;
use crate::sampling::batch::SetPoints;
use crate::shading::phong::local_light;
use crate::shading::{Lamp, WithLamp, WithLamps, lobe};

/// One ray from every point to a light.
#[derive(Clone, Copy, Debug)]
pub(in crate::integrator) struct Question {
    /// Index of the light. `None`: each point chooses one at random.
    pub(super) light: Option<u32>,
    /// Number of the ray, and the number of rays.
    pub(super) place: [u32; 2],
}

/// Returns the rays of all points to lights, by the settings.
pub(in crate::integrator) fn questions(
    frame: &FrameScene,
    depth: u32,
) -> impl Iterator<Item = Question> {
    let each = (0..frame.first_chosen).map(|number| (Some(number), number));
    let has_choice = (frame.first_chosen as usize) < frame.lights.len();
    let chosen = has_choice.then_some((None, frame.first_chosen));
    each.chain(chosen).flat_map(move |(light, like)| {
        let count = rays_to(frame, &frame.lights[like as usize], depth);
        (0..count).map(move |i| Question { light, place: [i, count] })
    })
}

/// Rays of one question from all points.
#[derive(Debug, Default)]
pub(in crate::integrator) struct DirectLight {
    set: SetPoints,
    choice: LightChoice,
    pub(in crate::integrator) sent: Sent,
    /// Points that send a ray.
    pub(in crate::integrator) chosen: Chosen,
}

impl DirectLight {
    /// Creates the rays of one question, except those whose light could add nothing. If `glossy`,
    /// it includes the light that lobes receive from lamps. Returns `None` if the work is given up.
    pub(in crate::integrator) fn ask(
        &mut self,
        job: &Job<'_>,
        points: &Points,
        lobes: &Lobes,
        glossy: bool,
        Question { light, place }: Question,
        depth: u32,
    ) -> Option<()> {
        let frame = job.frame;
        let Self { set, choice, sent, chosen } = self;
        let purpose = light.map_or(Purpose::AnyLight, Purpose::Light);
        let least = if depth > 0 { least_weight(frame) } else { 0.0 };
        let names = points.names(&frame.settings, depth, purpose, place);
        if light.is_some() && least == 0.0 {
            set.take::<2>(&frame.sampler, frame.isa, &names);
        } else {
            set.take::<3>(&frame.sampler, frame.isa, &names);
        }
        let first = &frame.lights[light.unwrap_or(0) as usize];
        let tries = mean_rays_to(frame, first, depth);
        let rays = [Purpose::Reflection, Purpose::Refraction]
            .map(|purpose| glossy_samples(&frame.settings, purpose, depth) as f32);
        if light.is_some() {
            let survival = &set.numbers[2];
            let from = Asking { points, lobes, set, survival, tries, rays, least };
            first.with(AskOne { frame, glossy, from, to: sent });
        } else {
            choice.choose(job, points, &set.numbers[2]);
            let survival = choice.rest();
            let from = Asking { points, lobes, set, survival, tries, rays, least };
            frame.lights.for_each_kind(&mut AskChosen { frame, glossy, from, choice, to: sent });
        }
        chosen.set(frame.isa, points.len(), |i| sent.weight.get(i) != Vec3::ZERO);
        Some(())
    }

    /// Returns the number of the light that point `i` asks.
    pub(in crate::integrator) fn light(&self, question: Question, i: usize) -> u32 {
        question.light.unwrap_or_else(|| self.choice.light()[i])
    }
}

/// What the rays from all points to lights have in common.
#[derive(Clone, Copy)]
struct Asking<'a> {
    points: &'a Points,
    lobes: &'a Lobes,
    set: &'a SetPoints,
    /// Random number of the roulette, for each point.
    survival: &'a Column<f32>,
    /// See [`mean_rays_to`].
    tries: f32,
    /// Number of rays of a glossy lobe: reflected, refracted.
    rays: [f32; 2],
    /// Weight below which rays are subject to roulette. It is 0 at first hits: where all is dark,
    /// their light is all that is visible.
    least: f32,
}

/// Rays from all points to one light.
struct AskOne<'a> {
    frame: &'a FrameScene,
    glossy: bool,
    from: Asking<'a>,
    to: &'a mut Sent,
}

impl WithLamp for AskOne<'_> {
    type Output = ();

    fn run<L: Lamp>(self, lamp: L) {
        let Self { frame, glossy, from, to } = self;
        // A copy, which cannot alias a column.
        ask(frame, glossy, from, |_| (lamp, 1.0, true), to);
    }
}

/// Rays from each point to the light that was chosen for it.
struct AskChosen<'a> {
    frame: &'a FrameScene,
    glossy: bool,
    from: Asking<'a>,
    choice: &'a LightChoice,
    to: &'a mut Sent,
}

impl WithLamps for AskChosen<'_> {
    fn run<L: Lamp>(
        &mut self,
        lamps: &[L],
        mine: impl Fn(u32) -> bool,
        place: impl Fn(u32) -> usize,
    ) {
        let (light, times) = (self.choice.light(), self.choice.times());
        let Some(last) = lamps.len().checked_sub(1) else { return };
        let choose = |i: usize| (lamps[place(light[i]).min(last)], times[i], mine(light[i]));
        ask(self.frame, self.glossy, self.from, choose, self.to);
    }
}

/// Creates a ray from every point `i` to a light. `choose(i)` returns the light, the weight of the
/// choice, and whether to ask the light. If not, the point keeps the ray that it has.
fn ask<L: Lamp>(
    frame: &FrameScene,
    glossy: bool,
    from: Asking<'_>,
    choose: impl Fn(usize) -> (L, f32, bool),
    to: &mut Sent,
) {
    match (glossy, from.points.shines) {
        (false, false) => frame.isa.run(Ask::<false, false, _> { from, choose, to }),
        (false, true) => frame.isa.run(Ask::<true, false, _> { from, choose, to }),
        (true, _) => frame.isa.run(Ask::<true, true, _> { from, choose, to }),
    }
}

struct Ask<'a, const SHINES: bool, const GLOSSY: bool, C> {
    from: Asking<'a>,
    choose: C,
    to: &'a mut Sent,
}

impl<L: Lamp, const SHINES: bool, const GLOSSY: bool, C> Lanewise for Ask<'_, SHINES, GLOSSY, C>
where
    C: Fn(usize) -> (L, f32, bool),
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        ask_lanes::<SHINES, GLOSSY, L>(&self.from, &self.choose, self.to);
    }
}

#[inline(always)]
fn ask_lanes<const SHINES: bool, const GLOSSY: bool, L: Lamp>(
    &Asking { points, lobes, set, survival, tries, rays, least }: &Asking<'_>,
    choose: &impl Fn(usize) -> (L, f32, bool),
    to: &mut Sent,
) {
    let surfaces = &points.surfaces;
    let share = 1.0 / tries;
    for i in lanes(surfaces.len) {
        let (light, times, is_asked) = choose(i);
        let hit = surfaces.point.get(i);
        let target = light.point(hit, [set.numbers[0][i], set.numbers[1][i]]);
        let way = target - hit;
        let distance = way.length();
        let toward = way * (1.0 / distance);
        let n_shade = surfaces.n_shade.get(i);
        let reflected = local_light::<SHINES>(
            [points.diffuse.get(i), points.specular.get(i)],
            points.shininess[i],
            n_shade,
            toward,
            -points.direction.get(i),
        );
        // The geometric normal decides whether light comes from the front, not the interpolated
        // one.
        let front = toward.dot(surfaces.n_geo.get(i)) > 0.0;
        let mut added = if front { reflected * share } else { Vec3::ZERO };
        if GLOSSY {
            let by_light = tries * light.density(hit, way);
            let reflected = lobes.reflected.share_of_light(i, toward, by_light, rays[0]);
            let refracted = lobes.refracted.share_of_light(i, toward, by_light, rays[1]);
            added += points.weight.get(i) * if front { reflected } else { refracted };
        }
        let origin = surfaces.leave(i, toward);
        let (direction, t_max) = light.shadow_ray(origin, target);
        to.origin.set(i, if is_asked { origin } else { to.origin.get(i) });
        to.direction.set(i, if is_asked { direction } else { to.direction.get(i) });
        to.t_max[i] = if is_asked { t_max } else { to.t_max[i] };
        // The limit scales with a dim light, so that its rays are not removed more often than those
        // of a bright one.
        let radiance = light.radiance(way);
        let least = least * radiance.max_element().min(1.0);
        let weight = roulette(added * radiance * times, least, survival[i]);
        let weight = if to.is_ray(i) { weight } else { Vec3::ZERO };
        to.weight.set(i, if is_asked { weight } else { to.weight.get(i) });
    }
}

impl Lobe {
    /// Returns the share of one ray to a lamp in the light that the lobe of point `i` receives from
    /// it, if rays to the lamp and rays of the lobe both sample this light. There are `by_light`
    /// rays to the lamp per solid angle, and `rays` rays of the lobe.
    ///
    /// Source: E. Veach and L. Guibas, "Optimally Combining Sampling Techniques" (1995), balance
    /// heuristic.
    #[inline(always)]
    fn share_of_light(&self, i: usize, toward: Vec3, by_light: f32, rays: f32) -> f32 {
        let density = lobe::density(self.axis.get(i), self.inverse.0[i], self.side.get(i), toward);
        let share = self.weight.0[i] * density / (by_light + rays * density);
        if density > 0.0 { share } else { 0.0 }
    }
}
