//! Rays from the hits of a batch to lamps, with the light that lobes make of them.

use glam::Vec3;
use slo_accel::Lanewise;
use slo_accel::math::columns::{BATCH, Column, Vec3s, lanes, select};

use super::bsdfs::Bsdfs;
use super::guiding::{Densities, Guiding, mixed};
use super::points::Points;
use crate::frame::FrameScene;
use crate::integrator::batch::{Labels, Sent};
use crate::integrator::branching::continuations;
use crate::integrator::chosen::Chosen;
use crate::integrator::work::Job;
use crate::sampling::Purpose;
use crate::sampling::batch::SetPoints;
use crate::shading::bsdf::{Lobe, WithLobe};
use crate::shading::light::{Choices, Moving, Sampled, Samples};
use crate::shading::{Lamp, WithLamp, WithLamps};

use super::direct_light::Question;

/// So many lights are asked one after the other, in loops that are vector code. Of more lights, each
/// point fetches its own.
const FEW: usize = 8;

/// Rays of one question from all points.
#[derive(Debug)]
pub(in crate::integrator) struct LampLight {
    set: SetPoints,
    choices: Choices,
    /// Points of a light that looks up tables.
    samples: Option<Box<Samples>>,
    /// Index of the light of each point.
    pub(super) light: Column<u32>,
    /// Number of rays to the light: the probability of the choice, times the number of rays.
    tries: Column<f32>,
    /// Unit directions to the points of lamps.
    pub(super) toward: Vec3s,
    /// Radiance of the lamp, or irradiance if it has no area.
    radiance: Vec3s,
    /// `pdf_solid_angle` of all rays to the lamp; `tries` if it has no area.
    by_light: Column<f32>,
    /// 1 if rays that follow lobes can hit the lamp, otherwise 0.
    hittable: Column<f32>,
    /// Factor of lobes that the thesis's lights reach without falloff; 0 for other lamps.
    flat: Column<f32>,
    /// Share of light in sharp lobes that photons leave to the rays.
    left: Column<f32>,
    field: Densities,
    /// Light that all lobes scatter, for a radiance of 1.
    scattered: Vec3s,
    pub(in crate::integrator) sent: Sent,
    pub(in crate::integrator) labels: Labels,
    /// Points that send a ray.
    pub(in crate::integrator) chosen: Chosen,
}

impl Default for LampLight {
    fn default() -> Self {
        let zeros = [0.0; BATCH];
        Self {
            set: SetPoints::default(),
            choices: Choices::default(),
            samples: None,
            light: [0; BATCH],
            tries: zeros,
            toward: Vec3s::default(),
            radiance: Vec3s::default(),
            by_light: zeros,
            hittable: zeros,
            flat: zeros,
            left: [1.0; BATCH],
            field: Densities::default(),
            scattered: Vec3s::default(),
            sent: Sent::default(),
            labels: Labels::default(),
            chosen: Chosen::default(),
        }
    }
}

impl LampLight {
    /// Creates the rays of one question, except those whose light could add nothing.
    pub(in crate::integrator) fn ask(
        &mut self,
        job: &Job<'_>,
        points: &Points,
        (bsdfs, guiding): (&Bsdfs, &Guiding),
        question: Question,
        depth: u32,
    ) {
        let frame = job.frame;
        let Question { light, place } = question;
        let purpose = light.map_or(Purpose::AnyLight, Purpose::Light);
        let names = points.names(&frame.settings, depth, purpose, place);
        // A light that is alone is always chosen.
        let alone = (frame.lights.len() == 1).then_some(0);
        if let Some(number) = light.or(alone) {
            self.set.take::<2>(&frame.sampler, frame.isa, &names);
            self.tries[..].fill(place[1] as f32);
            self.light[..].fill(number);
            frame.lights[number as usize].with(AskOne { frame, points, number, to: self });
        } else {
            self.set.take::<3>(&frame.sampler, frame.isa, &names);
            self.choose(frame, points, place[1] as f32);
            if frame.lights.len() <= FEW {
                for (number, light) in (0..).zip(frame.lights.iter()) {
                    light.with(AskOne { frame, points, number, to: self });
                }
            } else {
                frame.lights.for_each_kind(&mut AskChosen { frame, points, to: self });
            }
        }
        self.share_with_photons(frame, points);
        guiding.densities(job, &self.toward, points.len(), |i| i, &mut self.field);
        let Self { scattered, toward, by_light, hittable, flat, left, field, .. } = self;
        *scattered = Vec3s::default();
        let rays = continuations(&frame.settings, depth) as f32;
        let field = &field.of;
        let arriving = Arriving { points, toward, by_light, hittable, flat, left, field, rays };
        bsdfs.bsdf.for_each(&mut Scatter { frame, guiding, arriving, to: scattered });
        frame.isa.run(Finish { points, to: self });
        let weight = &self.sent.weight;
        let (light, shaded) = (&self.light, frame.first_shaded);
        let is_sent = |i: usize| (weight.get(i) != Vec3::ZERO) & (light[i] < shaded);
        self.chosen.set(frame.isa, points.len(), is_sent);
    }

    /// Returns the number of the light that point `i` asks.
    pub(in crate::integrator) fn light(&self, i: usize) -> u32 {
        self.light[i]
    }

    /// Labels the rays: like the points, but with the slots of the groups that the lights belong to,
    /// at a distance of `stride` from each other.
    pub(in crate::integrator) fn name(&mut self, frame: &FrameScene, points: &Points, stride: u32) {
        let (labels, len) = (&mut self.labels, points.len());
        labels.time[..len].copy_from_slice(&points.labels.time[..len]);
        labels.slot[..len].copy_from_slice(&points.labels.slot[..len]);
        if stride > 0 {
            for (slot, light) in labels.slot[..len].iter_mut().zip(&self.light) {
                *slot += frame.group_of(*light) * stride;
            }
        }
    }

    /// Finds which share of the light in sharp lobes photons leave to the rays: of paths that left a
    /// rough lobe before.
    fn share_with_photons(&mut self, frame: &FrameScene, points: &Points) {
        let Some(emission) = &frame.emission else { return };
        let last = frame.lights.len().saturating_sub(1) as u32;
        for i in 0..points.len() {
            let rival = points.rough.rival[i];
            self.left[i] = 1.0;
            if rival > 0.0 && self.light[i] <= last {
                let point = self.sent.origin.get(i) + self.sent.direction.get(i);
                let (light, time) = (self.light[i], points.labels.time[i]);
                let toward = self.toward.get(i);
                let density = emission.density(&frame.lights, light, time, point, -toward);
                self.left[i] = rival / (rival + density);
            }
        }
    }

    /// Chooses a light for each point.
    fn choose(&mut self, frame: &FrameScene, points: &Points, rays: f32) {
        let Self { set, choices, light, tries, radiance, .. } = self;
        let Points { surfaces, receiver, .. } = points;
        let (point, u) = (&surfaces.start, &set.numbers[2]);
        frame.light_tree.choose_all(frame.isa, points.len(), point, receiver, u, choices);
        for (light, &chosen) in light.iter_mut().zip(&choices.light) {
            *light = frame.first_chosen.saturating_add(chosen);
        }
        for (tries, chance) in tries.iter_mut().zip(&choices.chance) {
            *tries = chance * rays;
        }
        // Points that no light can reach have none, and ask none.
        *radiance = Vec3s::default();
    }
}

/// Rays from all points to one light.
struct AskOne<'a> {
    frame: &'a FrameScene,
    points: &'a Points,
    /// Index of the light.
    number: u32,
    to: &'a mut LampLight,
}

impl WithLamp for AskOne<'_> {
    type Output = ();

    fn run<L: Lamp>(self, lamp: L) {
        let Self { frame, points, number, to } = self;
        if frame.lights.move_about() {
            let pose = |i: usize| frame.lights.pose(number, points.labels.time[i]);
            let choose = |light: u32, i: usize| (Moving { lamp, pose: pose(i) }, light == number);
            frame.isa.run(Ask::<_, _, true> { points, choose, from: Itself, to });
            return;
        }
        // A copy of the lamp cannot alias a column.
        let choose = move |light: u32, _: usize| (lamp, light == number);
        if L::LOOKS_UP {
            let mut samples = to.samples.take().unwrap_or_default();
            let hits = (&points.surfaces.start, points.len());
            let [u, v, _] = &to.set.numbers;
            lamp.sample_each(frame.isa, hits, [u, v], |i| to.light[i] == number, &mut samples);
            let from = LookedUp(&samples);
            frame.isa.run(Ask::<_, _, false> { points, choose, from, to });
            to.samples = Some(samples);
        } else {
            frame.isa.run(Ask::<_, _, false> { points, choose, from: Itself, to });
        }
    }
}

/// Rays from each point to the light that was chosen for it.
struct AskChosen<'a> {
    frame: &'a FrameScene,
    points: &'a Points,
    to: &'a mut LampLight,
}

impl WithLamps for AskChosen<'_> {
    fn run<L: Lamp>(
        &mut self,
        lamps: &[L],
        mine: impl Fn(u32) -> bool,
        place: impl Fn(u32) -> usize,
    ) {
        let (frame, points) = (self.frame, self.points);
        let count = frame.lights.len() as u32;
        let Some(last) = lamps.len().checked_sub(1) else { return };
        let choose = |light: u32| (lamps[place(light).min(last)], mine(light) & (light < count));
        if frame.lights.move_about() {
            let pose = |light: u32, i: usize| frame.lights.pose(light, points.labels.time[i]);
            let choose = |light: u32, i: usize| {
                let (lamp, is_asked) = choose(light);
                (Moving { lamp, pose: pose(light, i) }, is_asked)
            };
            frame.isa.run(Ask::<_, _, true> { points, choose, from: Itself, to: self.to });
        } else {
            let choose = |light: u32, _: usize| choose(light);
            frame.isa.run(Ask::<_, _, true> { points, choose, from: Itself, to: self.to });
        }
    }
}

/// Creates a ray from every point to a light. `choose(light, i)` returns the light with an index
/// as point `i` sees it, and whether to ask it. If not, the point keeps the ray that it has, and is
/// skipped if `SKIPS`; otherwise the loop has no branches.
struct Ask<'a, C, S, const SKIPS: bool> {
    points: &'a Points,
    choose: C,
    /// Where samples of the light come from.
    from: S,
    to: &'a mut LampLight,
}

/// Where samples of a light come from.
trait Source {
    /// Returns the sample of a light for hit `i`, which is at `hit`, by a point `u` of the unit
    /// square.
    fn sample<L: Lamp>(&self, lamp: L, i: usize, hit: Vec3, u: [f32; 2]) -> Sampled;
}

/// The light itself.
struct Itself;

/// Samples that were taken before.
struct LookedUp<'a>(&'a Samples);

impl Source for Itself {
    #[inline(always)]
    fn sample<L: Lamp>(&self, lamp: L, _: usize, hit: Vec3, u: [f32; 2]) -> Sampled {
        lamp.sample(hit, u)
    }
}

impl Source for LookedUp<'_> {
    #[inline(always)]
    fn sample<L: Lamp>(&self, _: L, i: usize, _: Vec3, _: [f32; 2]) -> Sampled {
        self.0.get(i)
    }
}

impl<L, C, S, const SKIPS: bool> Lanewise for Ask<'_, C, S, SKIPS>
where
    L: Lamp,
    C: Fn(u32, usize) -> (L, bool),
    S: Source,
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { points, choose, from, to } = self;
        let surfaces = &points.surfaces;
        for i in lanes(surfaces.len) {
            let (lamp, is_asked) = choose(to.light[i], i);
            if SKIPS && !is_asked {
                continue;
            }
            let hit = surfaces.start.get(i);
            let u = [to.set.numbers[0][i], to.set.numbers[1][i]];
            let Sampled { way, radiance, density } = from.sample(lamp, i, hit, u);
            let toward = if L::IS_DISTANT { way } else { way * (1.0 / way.length()) };
            let origin = surfaces.depart(i, toward);
            let (direction, t_max) = if L::IS_DISTANT {
                (way, f32::INFINITY)
            } else {
                lamp.shadow_ray(origin, hit + way)
            };
            let tries = to.tries[i];
            let by_light = if L::IS_DELTA { tries } else { tries * density };
            let flat = if L::IS_OF_THESIS { std::f32::consts::PI / tries } else { 0.0 };
            to.sent.origin.set_if(i, is_asked, origin);
            to.sent.direction.set_if(i, is_asked, direction);
            to.sent.t_max[i] = select(is_asked, t_max, to.sent.t_max[i]);
            to.toward.set_if(i, is_asked, toward);
            to.radiance.set_if(i, is_asked, radiance);
            to.by_light[i] = select(is_asked, by_light, to.by_light[i]);
            let hittable = if L::IS_DELTA { 0.0 } else { 1.0 };
            to.hittable[i] = select(is_asked, hittable, to.hittable[i]);
            to.flat[i] = select(is_asked, flat, to.flat[i]);
        }
    }
}

/// Light that arrives at the points, before any lobe.
#[derive(Clone, Copy)]
struct Arriving<'a> {
    points: &'a Points,
    toward: &'a Vec3s,
    by_light: &'a Column<f32>,
    hittable: &'a Column<f32>,
    flat: &'a Column<f32>,
    left: &'a Column<f32>,
    /// Densities of the field.
    field: &'a Column<f32>,
    /// Number of continuations of each hit.
    rays: f32,
}

/// Adds what each lobe makes of the light.
struct Scatter<'a> {
    frame: &'a FrameScene,
    guiding: &'a Guiding,
    arriving: Arriving<'a>,
    to: &'a mut Vec3s,
}

impl WithLobe for Scatter<'_> {
    fn run<L: Lobe>(&mut self, lobe: &L) {
        let (asked, partner) = self.frame.techniques.asked(L::IS_DIFFUSE);
        let (share, arriving) = (self.guiding.share(L::IS_DIFFUSE), self.arriving);
        let work = ScatterOne { lobe, share, arriving, asked, partner, to: self.to };
        self.frame.isa.run(work);
    }
}

struct ScatterOne<'a, L> {
    lobe: &'a L,
    /// Share of the field in the rays of the lobe.
    share: &'a Column<f32>,
    arriving: Arriving<'a>,
    /// See [`Techniques::asked`](crate::shading::light::Techniques::asked).
    asked: f32,
    partner: f32,
    to: &'a mut Vec3s,
}

impl<L: Lobe> Lanewise for ScatterOne<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { lobe, share: shares, arriving, asked, partner, to } = self;
        let Arriving { points, toward, by_light, hittable, flat, left, field, rays } = arriving;
        let chance = &lobe.share().chance;
        for i in lanes(points.surfaces.len) {
            let (at, toward) = (points.at(i), toward.get(i));
            let scattered = lobe.evaluate(i, &at, toward);
            let is_sharp = lobe.is_sharp(i);
            let density =
                mixed(scattered.density, field[i], if is_sharp { 0.0 } else { shares[i] });
            let by_lobe = hittable[i] * partner * rays * chance[i] * density;
            let share = 1.0 / (by_light[i] + by_lobe);
            // Lamps without an area are found by asking only, whatever the techniques.
            let asked = if hittable[i] == 0.0 { 1.0 } else { asked };
            let is_flat = (flat[i] > 0.0) & (L::IS_DIFFUSE | (hittable[i] == 0.0));
            let share = if is_flat { flat[i] } else { share * asked };
            let shows = L::SHOWS_POINTS | (hittable[i] != 0.0);
            let is_shared = is_sharp & at.is_two_way(toward);
            let left = if is_shared { left[i] } else { 1.0 };
            let value = scattered.value * if shows { share * left } else { 0.0 };
            to.set(i, to.get(i) + value);
        }
    }
}

/// Weights the rays.
struct Finish<'a> {
    points: &'a Points,
    to: &'a mut LampLight,
}

impl Lanewise for Finish<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { points, to } = self;
        for i in lanes(points.surfaces.len) {
            let weight = points.weight.get(i) * to.scattered.get(i) * to.radiance.get(i);
            let is_lit = (weight.max_element() > 0.0) & to.sent.is_ray(i);
            to.sent.weight.set(i, if is_lit { weight } else { Vec3::ZERO });
        }
    }
}
