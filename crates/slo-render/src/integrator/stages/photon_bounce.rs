//! Rays of photons that go on: each follows one lobe of a hit, or one sharp lobe.

use glam::Vec3;
use slo_accel::Lanewise;
use slo_accel::math::columns::{BATCH, Column, lanes, select};

use super::bsdfs::{Bsdfs, LookBack};
use super::continuation::Name;
use super::hits::Hits;
use super::points::Points;
use crate::frame::FrameScene;
use crate::integrator::batch::{Batch, Labels, Past, Sent, marks};
use crate::integrator::chosen::Chosen;
use crate::sampling::Purpose;
use crate::sampling::batch::SetPoints;
use crate::shading::bsdf::{At, Lobe, WithLobe, WithLobes};

/// One ray from every point, at most.
#[derive(Debug, Default)]
pub(in crate::integrator) struct PhotonBounce {
    set: SetPoints,
    survival: SetPoints,
    choice: Choice,
    back: LookBack,
    pub(in crate::integrator) sent: Sent,
    pub(in crate::integrator) labels: Labels,
    pub(in crate::integrator) past: Past,
    /// Points that send a ray.
    pub(in crate::integrator) chosen: Chosen,
}

impl PhotonBounce {
    /// Creates the rays: those that follow rough lobes only if `rough` says so. Their random numbers
    /// are those of hits after `depth` bounces.
    pub(in crate::integrator) fn send(
        &mut self,
        frame: &FrameScene,
        batch: &Batch,
        points: &Points,
        bsdfs: &Bsdfs,
        (depth, rough): (u32, bool),
    ) {
        let Self { set, survival, choice, back, sent, labels, past, .. } = self;
        choice.restart(rough);
        bsdfs.bsdf.for_each(&mut AddUp { frame, points, choice });
        let place = [0, 1];
        let names = points.names(&frame.settings, depth, Purpose::Continuation, place);
        set.take::<3>(&frame.photon_sampler, frame.isa, &names);
        let names = points.names(&frame.settings, depth, Purpose::Survival, place);
        survival.take::<2>(&frame.photon_sampler, frame.isa, &names);
        for column in [&mut sent.weight.x, &mut sent.weight.y, &mut sent.weight.z] {
            column.fill(0.0);
        }
        past.marks = [0; BATCH];
        bsdfs.bsdf.for_each(&mut Follow { frame, points, set, choice, sent, past });
        if bsdfs.look_back(frame, points, &sent.direction, back) {
            choice.begin_again();
            let mut exchange = Exchange { frame, points, set, choice, sent };
            bsdfs.bsdf.for_each_with(&back.bsdf, &mut exchange);
        }
        frame.isa.run(Finish { points, survival, sent });
        frame.isa.run(Name { points, place, next: labels });
        for i in 0..points.len() {
            let ray = points.surfaces.ray[i] as usize;
            sent.density[i] = batch.density[ray];
            past.marks[i] |= batch.past.marks[ray] & (marks::SHARP | marks::ROUGH);
        }
        let weight = &self.sent.weight;
        self.chosen.set(frame.isa, points.len(), |i| weight.get(i) != Vec3::ZERO);
    }
}

impl PhotonBounce {
    /// Sends the photons of lights that are shaded where rays arrive, and nothing else from where a ray
    /// looks back at such a light: the light that it emits toward the ray.
    pub(in crate::integrator) fn kindle(
        &mut self,
        frame: &FrameScene,
        batch: &Batch,
        hits: &Hits,
        points: &Points,
        bsdfs: &Bsdfs,
    ) {
        let Self { sent, past, .. } = self;
        for i in 0..points.len() {
            let ray = points.surfaces.ray[i] as usize;
            let asked = marks::asked(batch.past.marks[ray]);
            if asked == 0 {
                continue;
            }
            let is_asked = frame.emitter(&hits.found, ray) == Some(frame.first_shaded + asked - 1);
            let light = points.weight.get(i) * bsdfs.emitted(i);
            let is_sent = is_asked && light.max_element() > 0.0 && light.is_finite();
            let way = -points.direction.get(i);
            sent.direction.set(i, way);
            sent.origin.set(i, points.surfaces.leave(i, way));
            sent.weight.set(i, if is_sent { light } else { Vec3::ZERO });
            past.marks[i] = 0;
        }
        let weight = &self.sent.weight;
        self.chosen.set(frame.isa, points.len(), |i| weight.get(i) != Vec3::ZERO);
    }
}

/// Which lobe the ray of each point follows: one of those that rays follow, by their chances.
#[derive(Debug)]
struct Choice {
    /// Whether rays follow rough lobes too.
    rough: bool,
    /// Sum of the chances of all lobes that rays follow.
    total: Column<f32>,
    /// Sum of the chances of those visited so far, of 1.
    below: Column<f32>,
}

impl Default for Choice {
    fn default() -> Self {
        Self { rough: false, total: [0.0; BATCH], below: [0.0; BATCH] }
    }
}

impl Choice {
    /// Begins with other points.
    fn restart(&mut self, rough: bool) {
        (self.rough, self.total, self.below) = (rough, [0.0; BATCH], [0.0; BATCH]);
    }

    /// Begins again with the first lobe.
    fn begin_again(&mut self) {
        self.below = [0.0; BATCH];
    }

    /// Whether rays may follow lobes of this kind.
    fn visits<L: Lobe>(&self) -> bool {
        L::IS_FOLLOWED && (self.rough || !L::IS_DIFFUSE)
    }

    /// Adds the chance of a lobe of point `i` to the sum of all. `rough` is that of `self`: loops that read
    /// it once can become vector code.
    #[inline(always)]
    fn add(&mut self, rough: bool, lobe: &impl Lobe, i: usize) {
        let is_followed = rough | lobe.is_sharp(i);
        self.total[i] += if is_followed { lobe.share().chance[i] } else { 0.0 };
    }

    /// Visits a lobe of point `i`. Returns whether the random number `u` chooses it, its chance, and
    /// where in it `u` lies, from 0 to 1. For `rough` see [`add`](Self::add).
    #[inline(always)]
    fn visit(&mut self, rough: bool, lobe: &impl Lobe, i: usize, u: f32) -> (bool, f32, f32) {
        let share = lobe.share().chance[i] / self.total[i];
        let chance = if rough | lobe.is_sharp(i) { share } else { 0.0 };
        let (start, end) = (self.below[i], self.below[i] + chance);
        self.below[i] = end;
        let rest = ((u - start) / chance).min(0.999_999_94);
        ((u >= start) & (u < end), chance, rest)
    }
}

/// Adds up the chances of lobes.
struct AddUp<'a> {
    frame: &'a FrameScene,
    points: &'a Points,
    choice: &'a mut Choice,
}

impl WithLobe for AddUp<'_> {
    fn run<L: Lobe>(&mut self, lobe: &L) {
        if self.choice.visits::<L>() {
            let Self { frame, points, choice } = self;
            frame.isa.run(AddUpOne { lobe, points, choice });
        }
    }
}

struct AddUpOne<'a, L> {
    lobe: &'a L,
    points: &'a Points,
    choice: &'a mut Choice,
}

impl<L: Lobe> Lanewise for AddUpOne<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { lobe, points, choice } = self;
        let rough = choice.rough;
        for i in lanes(points.surfaces.len) {
            choice.add(rough, lobe, i);
        }
    }
}

/// Samples each lobe at the points whose ray follows it.
struct Follow<'a> {
    frame: &'a FrameScene,
    points: &'a Points,
    set: &'a SetPoints,
    choice: &'a mut Choice,
    sent: &'a mut Sent,
    past: &'a mut Past,
}

impl WithLobe for Follow<'_> {
    fn run<L: Lobe>(&mut self, lobe: &L) {
        if self.choice.visits::<L>() {
            let Self { frame, points, set, choice, sent, past } = self;
            frame.isa.run(FollowOne { lobe, points, set, choice, sent, past });
        }
    }
}

struct FollowOne<'a, L> {
    lobe: &'a L,
    points: &'a Points,
    set: &'a SetPoints,
    choice: &'a mut Choice,
    sent: &'a mut Sent,
    past: &'a mut Past,
}

impl<L: Lobe> Lanewise for FollowOne<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { lobe, points, set, choice, sent, past } = self;
        let rough = choice.rough;
        for i in lanes(points.surfaces.len) {
            let [u, v, w] = set.numbers.each_ref().map(|column| column[i]);
            let (is_chosen, chance, rest) = choice.visit(rough, lobe, i, w);
            let at = points.at(i);
            let sampled = lobe.sample(i, &at, [u, v, rest]);
            let of_photon = lobe.of_photon(i, &at, sampled.direction);
            let of_photon = if at.is_two_way(sampled.direction) { of_photon } else { 0.0 };
            let weight = sampled.weight * (adjoint(&at, sampled.direction) * of_photon / chance);
            sent.direction.set_if(i, is_chosen, sampled.direction);
            sent.weight.set_if(i, is_chosen, weight);
            let mark = if lobe.is_sharp(i) { marks::SHARP } else { marks::ROUGH };
            past.marks[i] = select(is_chosen, mark, past.marks[i]);
        }
    }
}

/// Exchanges the arguments of the lobes that rays follow: a path from the camera sees the surface from
/// the other end, and what a layer leaves to those below depends on the eye.
struct Exchange<'a> {
    frame: &'a FrameScene,
    points: &'a Points,
    set: &'a SetPoints,
    choice: &'a mut Choice,
    sent: &'a mut Sent,
}

impl WithLobes for Exchange<'_> {
    fn run<L: Lobe>(&mut self, lobe: &L, other: &L) {
        if self.choice.visits::<L>() {
            let Self { frame, points, set, choice, sent } = self;
            frame.isa.run(ExchangeOne { lobe, other, points, set, choice, sent });
        }
    }
}

struct ExchangeOne<'a, L> {
    lobe: &'a L,
    other: &'a L,
    points: &'a Points,
    set: &'a SetPoints,
    choice: &'a mut Choice,
    sent: &'a mut Sent,
}

impl<L: Lobe> Lanewise for ExchangeOne<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { lobe, other, points, set, choice, sent } = self;
        let (mine, theirs) = (lobe.share(), other.share());
        // Lobes of Phong look the same from everywhere.
        let (is_there, rough) = (theirs.is_present, choice.rough);
        for i in lanes(points.surfaces.len) {
            let (is_chosen, ..) = choice.visit(rough, lobe, i, set.numbers[2][i]);
            let (from, to) = (mine.weight.get(i), theirs.weight.get(i));
            let ratio = |from: f32, to: f32| if from > 0.0 { to / from } else { 1.0 };
            let ratio = Vec3::new(ratio(from.x, to.x), ratio(from.y, to.y), ratio(from.z, to.z));
            let weight = sent.weight.get(i);
            sent.weight.set_if(i, is_chosen & is_there, weight * ratio);
        }
    }
}

/// Returns the factor by which the power of a photon differs from the weight of light that goes the
/// other way, because shading normals differ from geometric ones.
///
/// Source: E. Veach, "Robust Monte Carlo Methods for Light Transport Simulation" (1997), 5.3.
#[inline(always)]
fn adjoint(at: &At, direction: Vec3) -> f32 {
    let arriving = at.n.dot(at.eye) / at.n_geo.dot(at.eye);
    let leaving = at.n_geo.dot(direction) / at.n.dot(direction);
    let factor = (arriving * leaving).abs();
    if factor < f32::INFINITY { factor } else { 0.0 }
}

/// Weights the rays, and lets roulette choose those that go on, by how much of the light does.
struct Finish<'a> {
    points: &'a Points,
    survival: &'a SetPoints,
    sent: &'a mut Sent,
}

impl Lanewise for Finish<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { points, survival, sent } = self;
        let surfaces = &points.surfaces;
        for i in lanes(surfaces.len) {
            let before = points.weight.get(i);
            let after = before * sent.weight.get(i);
            let chance = (after.max_element() / before.max_element()).min(1.0);
            let goes_on = survival.numbers[0][i] < chance;
            let weight = after * (1.0 / chance);
            sent.origin.set(i, surfaces.leave(i, sent.direction.get(i)));
            sent.t_max[i] = f32::INFINITY;
            let is_ray = goes_on & (weight.max_element() > 0.0) & sent.is_ray(i);
            sent.weight.set(i, if is_ray { weight } else { Vec3::ZERO });
        }
    }
}
