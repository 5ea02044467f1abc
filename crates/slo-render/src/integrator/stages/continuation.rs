//! Rays that continue paths: each follows one lobe of a hit.

use glam::Vec3;
use slo_accel::Lanewise;
use slo_accel::math::columns::{BATCH, Column, lanes};

use super::bsdfs::Bsdfs;
use super::points::Points;
use crate::frame::FrameScene;
use crate::integrator::batch::{Labels, Past, Sent, marks};
use crate::integrator::chosen::Chosen;
use crate::integrator::roulette::follows;
use crate::sampling::batch::{SetPoints, place_of};
use crate::sampling::{Purpose, Use, next_path};
use crate::shading::bsdf::{Lobe, WithLobe};

/// One ray from every point.
#[derive(Debug)]
pub(in crate::integrator) struct Continuation {
    set: SetPoints,
    /// Random numbers of the roulette.
    survival: SetPoints,
    /// Sum of the chances of the lobes visited so far.
    below: Column<f32>,
    pub(in crate::integrator) sent: Sent,
    pub(in crate::integrator) labels: Labels,
    pub(in crate::integrator) past: Past,
    /// Points that send a ray.
    pub(in crate::integrator) chosen: Chosen,
}

impl Default for Continuation {
    fn default() -> Self {
        Self {
            set: SetPoints::default(),
            survival: SetPoints::default(),
            below: [0.0; BATCH],
            sent: Sent::default(),
            labels: Labels::default(),
            past: Past::default(),
            chosen: Chosen::default(),
        }
    }
}

impl Continuation {
    /// Creates ray number `place[0]` of `place[1]` from every point. If surface features are
    /// collected, `first_behind` is the first slot of light through rough lobes.
    pub(in crate::integrator) fn send(
        &mut self,
        frame: &FrameScene,
        points: &Points,
        bsdfs: &Bsdfs,
        place: [u32; 2],
        depth: u32,
        first_behind: Option<u32>,
    ) {
        let Self { set, survival, below, sent, past, labels, .. } = self;
        let names = points.names(&frame.settings, depth, Purpose::Continuation, place);
        set.take::<3>(&frame.sampler, frame.isa, &names);
        let names = points.names(&frame.settings, depth, Purpose::Survival, place);
        survival.take::<2>(&frame.sampler, frame.isa, &names);
        *below = [0.0; BATCH];
        for column in [&mut sent.weight.x, &mut sent.weight.y, &mut sent.weight.z] {
            column.fill(0.0);
        }
        let count = place[1] as f32;
        bsdfs.bsdf.for_each(&mut Follow { frame, points, set, count, below, sent, past });
        let always = depth == 0 || !frame.clever;
        frame.isa.run(Finish { points, survival, always, count, sent, past });
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
        let weight = &self.sent.weight;
        self.chosen.set(frame.isa, len, |i| weight.get(i) != Vec3::ZERO);
    }
}

/// Samples each lobe at the points whose ray follows it.
struct Follow<'a> {
    frame: &'a FrameScene,
    points: &'a Points,
    set: &'a SetPoints,
    /// Number of rays of each point.
    count: f32,
    below: &'a mut Column<f32>,
    sent: &'a mut Sent,
    past: &'a mut Past,
}

impl WithLobe for Follow<'_> {
    fn run<L: Lobe>(&mut self, lobe: &L) {
        if L::IS_FOLLOWED {
            let Self { frame, points, set, count, below, sent, past } = self;
            let count = *count;
            frame.isa.run(FollowOne { lobe, points, set, count, below, sent, past });
        }
    }
}

struct FollowOne<'a, L> {
    lobe: &'a L,
    points: &'a Points,
    set: &'a SetPoints,
    count: f32,
    below: &'a mut Column<f32>,
    sent: &'a mut Sent,
    past: &'a mut Past,
}

impl<L: Lobe> Lanewise for FollowOne<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { lobe, points, set, count, below, sent, past } = self;
        let chances = &lobe.share().chance;
        for i in lanes(points.surfaces.len) {
            let [u, v, w] = set.numbers.each_ref().map(|column| column[i]);
            let (chance, start) = (chances[i], below[i]);
            let end = start + chance;
            below[i] = end;
            let is_chosen = (w >= start) & (w < end);
            let rest = ((w - start) / chance).min(0.999_999_94);
            let sampled = lobe.sample(i, &points.at(i), [u, v, rest]);
            let share = 1.0 / (chance * count);
            let weight = sampled.weight * share;
            let density = sampled.density * chance * count;
            let keep = |new: Vec3, old: Vec3| if is_chosen { new } else { old };
            sent.direction.set(i, keep(sampled.direction, sent.direction.get(i)));
            sent.weight.set(i, keep(weight, sent.weight.get(i)));
            sent.density[i] = if is_chosen { density } else { sent.density[i] };
            let is_sharp = lobe.is_sharp(i);
            let mark = if L::IS_DIFFUSE { marks::DIFFUSE } else { 0 };
            let mark = mark | if is_sharp { marks::SHARP } else { 0 };
            past.marks[i] = if is_chosen { mark } else { past.marks[i] };
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
    sent: &'a mut Sent,
    past: &'a mut Past,
}

impl Lanewise for Finish<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { points, survival, always, count, sent, past } = self;
        let surfaces = &points.surfaces;
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
            past.from.set(i, surfaces.starts().get(i));
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
