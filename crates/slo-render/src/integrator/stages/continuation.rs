//! Rays that continue paths: each follows one lobe of a hit.

use glam::Vec3;
use slo_accel::Lanewise;
use slo_accel::math::columns::{BATCH, Column, Vec3s, lanes, select};

use super::bsdfs::Bsdfs;
use super::guiding::{Densities, Guiding, mixed};
use super::points::Points;
use crate::frame::FrameScene;
use crate::integrator::batch::{Labels, Past, Sent, marks};
use crate::integrator::chosen::Chosen;
use crate::integrator::roulette::follows;
use crate::integrator::work::Job;
use crate::sampling::batch::{SetPoints, place_of};
use crate::sampling::{Purpose, Use, next_path};
use crate::shading::bsdf::{Lobe, WithLobe};

/// One ray from every point.
#[derive(Debug, Default)]
pub(in crate::integrator) struct Continuation {
    set: SetPoints,
    /// Random numbers of the roulette.
    survival: SetPoints,
    pub(in crate::integrator) rays: Rays,
    pub(in crate::integrator) labels: Labels,
    /// Points that send a ray.
    pub(in crate::integrator) chosen: Chosen,
}

/// What the loops over lobes write. It is one object, so that one check tells whether a loop may
/// become vector code.
#[derive(Debug)]
pub(in crate::integrator) struct Rays {
    /// Sum of the chances of the lobes visited so far.
    below: Column<f32>,
    guided: Guided,
    pub(in crate::integrator) sent: Sent,
    pub(in crate::integrator) past: Past,
}

impl Default for Rays {
    fn default() -> Self {
        Self {
            below: [0.0; BATCH],
            guided: Guided::default(),
            sent: Sent::default(),
            past: Past::default(),
        }
    }
}

/// How the rays of rough lobes share their directions with the field.
#[derive(Debug)]
pub(in crate::integrator) struct Guided {
    /// Number of the lobe that each ray follows, in the order of the list.
    lobe: Column<u32>,
    /// 1 if its direction comes from the field, otherwise 0.
    by_field: Column<u32>,
    square: [Column<f32>; 2],
    /// Densities of the field in the directions of the rays.
    pub(super) field: Densities,
    /// Densities of the lobes alone, and of both.
    pub(super) own: Column<f32>,
    pub(super) mixed: Column<f32>,
}

impl Guided {
    /// Returns the packed direction of ray `i`.
    pub(super) fn toward(&self, i: usize) -> u32 {
        self.field.packed(i)
    }
}

impl Default for Guided {
    fn default() -> Self {
        let zeros = [0.0; BATCH];
        Self {
            lobe: [0; BATCH],
            by_field: [0; BATCH],
            square: [zeros; 2],
            field: Densities::default(),
            own: zeros,
            mixed: zeros,
        }
    }
}

impl Continuation {
    /// How the rays share their directions with the field, if they do.
    pub(super) fn guided(&self) -> &Guided {
        &self.rays.guided
    }

    /// Creates ray number `place[0]` of `place[1]` from every point. If surface features are
    /// collected, `first_behind` is the first slot of light through rough lobes.
    pub(in crate::integrator) fn send(
        &mut self,
        job: &Job<'_>,
        points: &Points,
        (bsdfs, guiding): (&Bsdfs, &Guiding),
        place: [u32; 2],
        depth: u32,
        first_behind: Option<u32>,
    ) {
        let frame = job.frame;
        let Self { set, survival, rays, labels, .. } = self;
        let names = points.names(&frame.settings, depth, Purpose::Continuation, place);
        set.take::<3>(&frame.sampler, frame.isa, &names);
        let names = points.names(&frame.settings, depth, Purpose::Survival, place);
        survival.take::<2>(&frame.sampler, frame.isa, &names);
        rays.below.fill(0.0);
        rays.sent.weight = Vec3s::default();
        rays.guided.by_field.fill(0);
        rays.guided.lobe.fill(u32::MAX);
        let count = place[1] as f32;
        bsdfs.bsdf.for_each(&mut Follow { frame, points, guiding, set, count, number: 0, rays });
        if job.is_guided() {
            let len = points.len();
            if let Some(field) = job.guide {
                let Guided { by_field, square, .. } = &mut rays.guided;
                let [u, v, _] = &set.numbers;
                let to = (square, &mut rays.sent.direction);
                guiding.sample(field, job, len, (&*by_field, [u, v]), to);
            }
            let directions = &rays.sent.direction;
            guiding.densities(job, directions, len, |i| i, &mut rays.guided.field);
            bsdfs.bsdf.for_each(&mut Reweigh { frame, points, guiding, count, number: 0, rays });
        }
        let always = depth == 0 || !frame.clever;
        frame.isa.run(Finish { points, survival, always, count, rays });
        let Rays { sent, past, .. } = rays;
        past.rough.is_kept = points.rough.is_kept;
        if past.rough.is_kept {
            frame.isa.run(Remember { points, sent, past });
        }
        frame.isa.run(Name { points, place, next: labels });
        let len = points.len();
        if let Some(first) = first_behind {
            for (slot, density) in labels.slot[..len].iter_mut().zip(&sent.density) {
                *slot += if *density > 0.0 && *slot < first { first } else { 0 };
            }
        }
        let weight = &self.rays.sent.weight;
        self.chosen.set(frame.isa, len, |i| weight.get(i) != Vec3::ZERO);
    }
}

/// Samples each lobe at the points whose ray follows it.
struct Follow<'a> {
    frame: &'a FrameScene,
    points: &'a Points,
    guiding: &'a Guiding,
    set: &'a SetPoints,
    /// Number of rays of each point.
    count: f32,
    /// Number of the lobe.
    number: u32,
    rays: &'a mut Rays,
}

impl WithLobe for Follow<'_> {
    fn run<L: Lobe>(&mut self, lobe: &L) {
        if L::IS_FOLLOWED {
            let Self { frame, points, guiding, set, count, number, rays } = self;
            let (share, count, number) = (guiding.share(L::IS_DIFFUSE), *count, *number);
            frame.isa.run(FollowOne { lobe, points, share, set, count, number, rays });
            self.number += 1;
        }
    }
}

struct FollowOne<'a, L> {
    lobe: &'a L,
    points: &'a Points,
    /// Share of the field in the rays of the lobe.
    share: &'a Column<f32>,
    set: &'a SetPoints,
    count: f32,
    number: u32,
    rays: &'a mut Rays,
}

impl<L: Lobe> Lanewise for FollowOne<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { lobe, points, share: shares, set, count, number, rays } = self;
        let Rays { below, guided, sent, past } = rays;
        let chances = &lobe.share().chance;
        for i in lanes(points.surfaces.len) {
            let [u, v, w] = set.numbers.each_ref().map(|column| column[i]);
            let (chance, start) = (chances[i], below[i]);
            let end = start + chance;
            below[i] = end;
            let is_chosen = (w >= start) & (w < end);
            let rest = (w - start) / chance;
            // One part of the rays of rough lobes is left to the field.
            let is_sharp = lobe.is_sharp(i);
            let field = if is_sharp { 0.0 } else { shares[i] };
            let is_left = rest < field;
            guided.by_field[i] |= u32::from(is_chosen & is_left);
            guided.lobe[i] = select(is_chosen, number, guided.lobe[i]);
            let rest = ((rest - field) / (1.0 - field)).clamp(0.0, 0.999_999_94);
            let sampled = lobe.sample(i, &points.at(i), [u, v, rest]);
            let share = 1.0 / (chance * count);
            let weight = sampled.weight * share;
            let density = sampled.density * chance * count;
            sent.direction.set_if(i, is_chosen, sampled.direction);
            sent.weight.set_if(i, is_chosen, weight);
            sent.density[i] = select(is_chosen, density, sent.density[i]);
            let mark = if L::IS_DIFFUSE { marks::DIFFUSE } else { 0 };
            let mark = mark | if is_sharp { marks::SHARP } else { 0 };
            past.marks[i] = select(is_chosen, mark, past.marks[i]);
        }
    }
}

/// Weights the rays of rough lobes by the density of the lobe and the field together.
struct Reweigh<'a> {
    frame: &'a FrameScene,
    points: &'a Points,
    guiding: &'a Guiding,
    count: f32,
    /// Number of the lobe.
    number: u32,
    rays: &'a mut Rays,
}

impl WithLobe for Reweigh<'_> {
    fn run<L: Lobe>(&mut self, lobe: &L) {
        if L::IS_FOLLOWED {
            let Self { frame, points, guiding, count, number, rays } = self;
            let (share, count, number) = (guiding.share(L::IS_DIFFUSE), *count, *number);
            frame.isa.run(ReweighOne { lobe, points, share, count, number, rays });
            self.number += 1;
        }
    }
}

struct ReweighOne<'a, L> {
    lobe: &'a L,
    points: &'a Points,
    share: &'a Column<f32>,
    count: f32,
    number: u32,
    rays: &'a mut Rays,
}

impl<L: Lobe> Lanewise for ReweighOne<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { lobe, points, share, count, number, rays } = self;
        let Rays { guided, sent, .. } = rays;
        let chances = &lobe.share().chance;
        for i in lanes(points.surfaces.len) {
            let is_mine = (guided.lobe[i] == number) & !lobe.is_sharp(i);
            let scattered = lobe.evaluate(i, &points.at(i), sent.direction.get(i));
            let both = mixed(scattered.density, guided.field.of[i], share[i]);
            let density = chances[i] * count * both;
            let scale = if density > 0.0 { 1.0 / density } else { 0.0 };
            let is_changed = is_mine & (share[i] > 0.0);
            let weight = scattered.value * scale;
            sent.weight.set_if(i, is_changed, weight);
            sent.density[i] = select(is_changed, density, sent.density[i]);
            guided.own[i] = select(is_mine, scattered.density, guided.own[i]);
            guided.mixed[i] = select(is_mine, both, guided.mixed[i]);
        }
    }
}

/// Weights the rays and lets roulette choose among weak ones.
struct Finish<'a> {
    points: &'a Points,
    survival: &'a SetPoints,
    /// Whether all rays are followed.
    always: bool,
    count: f32,
    rays: &'a mut Rays,
}

impl Lanewise for Finish<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { points, survival, always, count, rays } = self;
        let (surfaces, Rays { sent, past, .. }) = (&points.surfaces, rays);
        for i in lanes(surfaces.len) {
            let direction = sent.direction.get(i);
            let weight = points.weight.get(i) * sent.weight.get(i);
            let kept = follows(weight, count, survival.numbers[0][i]);
            let weight = if always { weight } else { kept };
            let origin = surfaces.depart(i, direction);
            sent.origin.set(i, origin);
            sent.t_max[i] = f32::INFINITY;
            let is_ray = (weight.max_element() > 0.0) & sent.is_ray(i);
            sent.weight.set(i, if is_ray { weight } else { Vec3::ZERO });
            past.from.set(i, surfaces.start.get(i));
            past.normal[i] = points.receiver[i];
        }
    }
}

/// By how much the footprint of a ray that left a rough lobe grows with distance, at least. Light that
/// comes that way is spread so widely that details in it don't show.
const ROUGH_SPREAD: f32 = 0.005;

/// Notes what the paths share with photons.
pub(super) struct Remember<'a> {
    pub(super) points: &'a Points,
    pub(super) sent: &'a Sent,
    pub(super) past: &'a mut Past,
}

impl Lanewise for Remember<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { points, sent, past } = self;
        let (before, rough) = (&points.rough, &mut past.rough);
        for i in lanes(points.surfaces.len) {
            let is_sharp = past.marks[i] & marks::SHARP != 0;
            let cos = points.surfaces.n_geo.get(i).dot(sent.direction.get(i)).abs();
            let rival = sent.density[i] / (cos * points.caught[i]);
            let is_real = points.at(i).is_real(sent.direction.get(i));
            let is_shared = (points.caught[i] > 0.0) & (cos > 0.0) & is_real;
            let rival = if is_shared { rival.min(f32::MAX) } else { 0.0 };
            let is_two_way = points.at(i).is_two_way(sent.direction.get(i));
            let kept = if is_two_way { before.rival[i] } else { 0.0 };
            rough.rival[i] = if is_sharp { kept } else { rival };
            rough.width[i] = before.width[i];
            let spread = before.spread[i];
            rough.spread[i] = if is_sharp { spread } else { spread.max(ROUGH_SPREAD) };
        }
    }
}

/// Sets the labels of the rays.
pub(super) struct Name<'a> {
    pub(super) points: &'a Points,
    /// Number of the ray, and the number of rays.
    pub(super) place: [u32; 2],
    pub(super) next: &'a mut Labels,
}

impl Lanewise for Name<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { points, place, next } = self;
        let (labels, branch) = (&points.labels, Use::from(Purpose::Continuation));
        for i in lanes(points.surfaces.len) {
            next.time[i] = labels.time[i];
            next.slot[i] = labels.slot[i];
            next.path[i] = next_path(labels.path[i], branch);
            next.index[i] = place_of(labels.index[i], place);
        }
    }
}
