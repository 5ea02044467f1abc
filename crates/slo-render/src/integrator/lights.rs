//! Rays from the hits of a batch to lights.

use glam::Vec3;

use super::bounces::{Lobe, Lobes, glossy_samples};
use super::light_choice::LightChoice;
use super::points::Points;
use super::queue::{Sent, ShadowKind};
use super::roulette::{least_weight, roulette};
use super::wave::Wave;
use crate::frame::FrameScene;
use crate::sampling::Purpose;
use crate::sampling::batch::SetPoints;
use crate::shading::phong::local_light;
use crate::shading::{AnyLight as Light, lobe};
use slo_accel::Lanewise;
use slo_accel::math::columns::{BATCH, Column, lanes};
use slo_scene::LightSampling;

/// Rays to lights that wait while the hits of one batch still send others.
const MOST_WAITING: usize = 16 * BATCH;

impl Wave {
    /// Rays from all points to the lights that the settings let them ask; `glossy` where points
    /// have lobes that send rays on. `None` if told to give up.
    pub(super) fn ask_lights(
        &mut self,
        frame: &FrameScene,
        glossy: bool,
        depth: u32,
        gives_up: &dyn Fn() -> bool,
    ) -> Option<()> {
        let query = Query {
            glossy: glossy && frame.combines(),
            rays: [Purpose::Reflection, Purpose::Refraction]
                .map(|purpose| glossy_samples(&frame.settings, purpose, depth) as f32),
            least: if depth > 0 { least_weight(frame) } else { 0.0 },
            depth,
        };
        match frame.settings.light_sampling {
            LightSampling::All => {
                for (number, light) in frame.lights.iter().enumerate() {
                    let count = rays_to(frame, light, depth);
                    for i in 0..count {
                        self.ask_light(frame, light, number as u32, [i, count], &query);
                        self.relieve(frame, depth, gives_up)?;
                    }
                }
            }
            LightSampling::One if frame.lights.is_empty() => {}
            LightSampling::One => {
                let count = rays_to(frame, &frame.lights[0], depth);
                for i in 0..count {
                    self.ask_any_light(frame, [i, count], &query, gives_up)?;
                    self.relieve(frame, depth, gives_up)?;
                }
            }
        }
        Some(())
    }

    /// Traces the rays to lights that wait, if they are many; `None` if told to give up.
    ///
    /// A hit sends as many as there are lights and samples of each, which only the scene bounds.
    fn relieve(
        &mut self,
        frame: &FrameScene,
        depth: u32,
        gives_up: &dyn Fn() -> bool,
    ) -> Option<()> {
        let kind = ShadowKind::at(depth);
        if self.waiting(kind) >= MOST_WAITING {
            while self.waiting(kind) >= BATCH {
                self.trace_shadows(frame, kind);
            }
        }
        (!gives_up()).then_some(())
    }

    /// Ray `i` of `count` from every point to one light.
    fn ask_light(
        &mut self,
        frame: &FrameScene,
        light: &Light,
        number: u32,
        place: [u32; 2],
        query: &Query,
    ) {
        if query.least > 0.0 {
            self.draw::<3>(frame, query.depth, Purpose::Light(number), place);
        } else {
            self.draw::<2>(frame, query.depth, Purpose::Light(number), place);
        }
        // A copy, which no column can overlap.
        let light = *light;
        self.ask(
            frame,
            &|_: &LightChoice, _: usize| (light, 1.0),
            tries(frame, &light, query.depth),
            query,
        );
    }

    /// Ray `i` of `count` from every point, each to a light at random, rather to a bright one. `None`
    /// if told to give up.
    fn ask_any_light(
        &mut self,
        frame: &FrameScene,
        place: [u32; 2],
        query: &Query,
        gives_up: &dyn Fn() -> bool,
    ) -> Option<()> {
        self.draw::<3>(frame, query.depth, Purpose::AnyLight, place);
        self.choice.choose(frame, &self.points, &self.set.numbers[2], gives_up)?;
        let choose = |choice: &LightChoice, i: usize| choice.of(&frame.lights, i);
        self.ask(frame, &choose, tries(frame, &frame.lights[0], query.depth), query);
        Some(())
    }

    /// A ray from every point to the light that `choose` gives it, unless that light could add
    /// nothing there.
    fn ask(
        &mut self,
        frame: &FrameScene,
        choose: &impl Fn(&LightChoice, usize) -> (Light, f32),
        tries: f32,
        &Query { glossy, rays, least, depth }: &Query,
    ) {
        let Self { points, lobes, set, choice, sent, chosen, .. } = self;
        let survival = match frame.settings.light_sampling {
            LightSampling::All => &set.numbers[2],
            LightSampling::One => choice.rest(),
        };
        let from = Asking { points, lobes, set, choice, survival, tries, rays, least };
        match (points.shines, glossy) {
            (false, false) => frame.isa.run(Ask::<false, false, _> { from, choose, to: sent }),
            (true, false) => frame.isa.run(Ask::<true, false, _> { from, choose, to: sent }),
            (_, true) => frame.isa.run(Ask::<true, true, _> { from, choose, to: sent }),
        }
        chosen.set(frame.isa, points.surfaces.len, |i| sent.weight.get(i) != Vec3::ZERO);
        self.shadows[ShadowKind::at(depth) as usize].append(sent, &points.labels, chosen);
    }
}

/// What the rays of all points to lights have in common.
struct Query {
    /// Whether light of lamps that glossy lobes receive is sought too.
    glossy: bool,
    /// How many rays a glossy lobe sends: reflected, refracted.
    rays: [f32; 2],
    /// Below which weight rays are left to chance. None is at the first hit: where all is dark, its
    /// light is all that there is to see.
    least: f32,
    depth: u32,
}

/// How many rays a hit sends to a light, or to lights at random.
fn rays_to(frame: &FrameScene, light: &Light, depth: u32) -> u32 {
    let one = frame.settings.light_sampling == LightSampling::One;
    if depth == 0 && (one || light.is_area()) { frame.settings.soft_shadow_samples } else { 1 }
}

/// How many rays a hit sends to a light, in the mean.
pub(super) fn tries(frame: &FrameScene, light: &Light, depth: u32) -> f32 {
    let rays = rays_to(frame, light, depth) as f32;
    match frame.settings.light_sampling {
        LightSampling::All => rays,
        LightSampling::One => rays / frame.lights.len() as f32,
    }
}

/// What is asked from where.
#[derive(Clone, Copy)]
struct Asking<'a> {
    points: &'a Points,
    lobes: &'a Lobes,
    set: &'a SetPoints,
    choice: &'a LightChoice,
    /// The number that decides whether a weak ray is sent.
    survival: &'a Column<f32>,
    /// See [`tries`].
    tries: f32,
    /// See [`Query::rays`].
    rays: [f32; 2],
    /// See [`Query::least`].
    least: f32,
}

struct Ask<'a, const SHINES: bool, const GLOSSY: bool, C> {
    from: Asking<'a>,
    choose: &'a C,
    to: &'a mut Sent,
}

impl<const SHINES: bool, const GLOSSY: bool, C> Lanewise for Ask<'_, SHINES, GLOSSY, C>
where
    C: Fn(&LightChoice, usize) -> (Light, f32),
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        ask::<SHINES, GLOSSY, C>(&self.from, self.choose, self.to);
    }
}

#[inline(always)]
fn ask<const SHINES: bool, const GLOSSY: bool, C: Fn(&LightChoice, usize) -> (Light, f32)>(
    &Asking { points, lobes, set, choice, survival, tries, rays, least }: &Asking<'_>,
    choose: &C,
    to: &mut Sent,
) {
    let surfaces = &points.surfaces;
    let share = 1.0 / tries;
    for i in lanes(surfaces.len) {
        let (light, times) = choose(choice, i);
        let target = light.point([set.numbers[0][i], set.numbers[1][i]]);
        let way = target - surfaces.point.get(i);
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
        // Lit from behind the surface itself, whatever the interpolated normal says.
        let front = toward.dot(surfaces.n_geo.get(i)) > 0.0;
        let mut added = if front { reflected * share } else { Vec3::ZERO };
        if GLOSSY {
            let by_light = tries * light.density(way);
            let reflected = lobes.reflected.share_of_light(i, toward, by_light, rays[0]);
            let refracted = lobes.refracted.share_of_light(i, toward, by_light, rays[1]);
            added += points.weight.get(i) * if front { reflected } else { refracted };
        }
        let origin = surfaces.leave(i, toward);
        let (direction, t_max) = light.shadow_ray(origin, target);
        to.origin.set(i, origin);
        to.direction.set(i, direction);
        to.t_max[i] = t_max;
        // A dim light must not be left to chance more than a bright one.
        let least = least * light.color.max_element().min(1.0);
        let weight = roulette(added * light.color * times, least, survival[i]);
        to.weight.set(i, if to.is_ray(i) { weight } else { Vec3::ZERO });
    }
}

impl Lobe {
    /// What one ray to a lamp brings of the light that the lobe of point `i` receives from it,
    /// where rays of both kinds look for it: `by_light` rays to the lamp per solid angle, and
    /// `rays` of the lobe.
    ///
    /// Source: E. Veach and L. Guibas, "Optimally Combining Sampling Techniques" (1995), the
    /// balance heuristic.
    #[inline(always)]
    fn share_of_light(&self, i: usize, toward: Vec3, by_light: f32, rays: f32) -> f32 {
        let density = lobe::density(self.axis.get(i), self.inverse.0[i], self.side.get(i), toward);
        let share = self.weight.0[i] * density / (by_light + rays * density);
        if density > 0.0 { share } else { 0.0 }
    }
}
