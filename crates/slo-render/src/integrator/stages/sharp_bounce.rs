//! Rays of photons that go on: each follows one sharp lobe of a hit.

use glam::Vec3;
use slo_accel::Lanewise;
use slo_accel::math::columns::{BATCH, Column, lanes};

use super::bsdfs::{Bsdfs, LookBack};
use super::continuation::Name;
use super::points::Points;
use crate::frame::FrameScene;
use crate::integrator::batch::{Batch, Labels, Past, Sent};
use crate::integrator::chosen::Chosen;
use crate::sampling::Purpose;
use crate::sampling::batch::SetPoints;
use crate::shading::bsdf::{At, Lobe, WithLobe, WithLobes};

/// One ray from every point with a sharp lobe.
#[derive(Debug)]
pub(in crate::integrator) struct SharpBounce {
    set: SetPoints,
    survival: SetPoints,
    /// Sum of the chances of all sharp lobes.
    total: Column<f32>,
    /// Sum of the chances of the sharp lobes visited so far, of 1.
    below: Column<f32>,
    back: LookBack,
    pub(in crate::integrator) sent: Sent,
    pub(in crate::integrator) labels: Labels,
    pub(in crate::integrator) past: Past,
    /// Points that send a ray.
    pub(in crate::integrator) chosen: Chosen,
}

impl Default for SharpBounce {
    fn default() -> Self {
        Self {
            set: SetPoints::default(),
            survival: SetPoints::default(),
            total: [0.0; BATCH],
            below: [0.0; BATCH],
            back: LookBack::default(),
            sent: Sent::default(),
            labels: Labels::default(),
            past: Past::default(),
            chosen: Chosen::default(),
        }
    }
}

impl SharpBounce {
    /// Creates the rays. Their random numbers are those of hits after `depth` bounces.
    pub(in crate::integrator) fn send(
        &mut self,
        frame: &FrameScene,
        batch: &Batch,
        points: &Points,
        bsdfs: &Bsdfs,
        depth: u32,
    ) {
        let Self { set, survival, total, below, back, sent, labels, past, .. } = self;
        *total = [0.0; BATCH];
        bsdfs.bsdf.for_each(&mut AddUp { frame, points, total });
        let place = [0, 1];
        let names = points.names(&frame.settings, depth, Purpose::Continuation, place);
        set.take::<3>(&frame.photon_sampler, frame.isa, &names);
        let names = points.names(&frame.settings, depth, Purpose::Survival, place);
        survival.take::<2>(&frame.photon_sampler, frame.isa, &names);
        *below = [0.0; BATCH];
        for column in [&mut sent.weight.x, &mut sent.weight.y, &mut sent.weight.z] {
            column.fill(0.0);
        }
        bsdfs.bsdf.for_each(&mut Follow { frame, points, set, total, below, sent });
        if bsdfs.look_back(frame, points, &sent.direction, back) {
            *below = [0.0; BATCH];
            let mut exchange = Exchange { frame, points, set, total, below, sent };
            bsdfs.bsdf.for_each_with(&back.bsdf, &mut exchange);
        }
        frame.isa.run(Finish { points, survival, sent });
        frame.isa.run(Name { points, place, next: labels });
        for i in 0..points.len() {
            sent.density[i] = batch.density[points.surfaces.ray[i] as usize];
            past.marks[i] = 0;
        }
        let weight = &self.sent.weight;
        self.chosen.set(frame.isa, points.len(), |i| weight.get(i) != Vec3::ZERO);
    }
}

/// Adds up the chances of sharp lobes.
struct AddUp<'a> {
    frame: &'a FrameScene,
    points: &'a Points,
    total: &'a mut Column<f32>,
}

impl WithLobe for AddUp<'_> {
    fn run<L: Lobe>(&mut self, lobe: &L) {
        if L::IS_FOLLOWED && !L::IS_DIFFUSE {
            let Self { frame, points, total } = self;
            frame.isa.run(AddUpOne { lobe, points, total });
        }
    }
}

struct AddUpOne<'a, L> {
    lobe: &'a L,
    points: &'a Points,
    total: &'a mut Column<f32>,
}

impl<L: Lobe> Lanewise for AddUpOne<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { lobe, points, total } = self;
        for i in lanes(points.surfaces.len) {
            total[i] += if lobe.is_sharp(i) { lobe.share().chance[i] } else { 0.0 };
        }
    }
}

/// Samples each sharp lobe at the points whose ray follows it.
struct Follow<'a> {
    frame: &'a FrameScene,
    points: &'a Points,
    set: &'a SetPoints,
    total: &'a Column<f32>,
    below: &'a mut Column<f32>,
    sent: &'a mut Sent,
}

impl WithLobe for Follow<'_> {
    fn run<L: Lobe>(&mut self, lobe: &L) {
        if L::IS_FOLLOWED && !L::IS_DIFFUSE {
            let Self { frame, points, set, total, below, sent } = self;
            frame.isa.run(FollowOne { lobe, points, set, total, below, sent });
        }
    }
}

struct FollowOne<'a, L> {
    lobe: &'a L,
    points: &'a Points,
    set: &'a SetPoints,
    total: &'a Column<f32>,
    below: &'a mut Column<f32>,
    sent: &'a mut Sent,
}

impl<L: Lobe> Lanewise for FollowOne<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { lobe, points, set, total, below, sent } = self;
        for i in lanes(points.surfaces.len) {
            let [u, v, w] = set.numbers.each_ref().map(|column| column[i]);
            let share = lobe.share().chance[i] / total[i];
            let chance = if lobe.is_sharp(i) { share } else { 0.0 };
            let (start, end) = (below[i], below[i] + chance);
            below[i] = end;
            let is_chosen = (w >= start) & (w < end);
            let rest = ((w - start) / chance).min(0.999_999_94);
            let at = points.at(i);
            let sampled = lobe.sample(i, &at, [u, v, rest]);
            let of_photon = lobe.of_photon(i, &at, sampled.direction);
            let of_photon = if at.is_two_way(sampled.direction) { of_photon } else { 0.0 };
            let weight = sampled.weight * (adjoint(&at, sampled.direction) * of_photon / chance);
            sent.direction.set_if(i, is_chosen, sampled.direction);
            sent.weight.set_if(i, is_chosen, weight);
        }
    }
}

/// Exchanges the arguments of the lobes that rays follow: a path from the camera sees the surface from
/// the other end, and what a layer leaves to those below depends on the eye.
struct Exchange<'a> {
    frame: &'a FrameScene,
    points: &'a Points,
    set: &'a SetPoints,
    total: &'a Column<f32>,
    below: &'a mut Column<f32>,
    sent: &'a mut Sent,
}

impl WithLobes for Exchange<'_> {
    fn run<L: Lobe>(&mut self, lobe: &L, other: &L) {
        if L::IS_FOLLOWED && !L::IS_DIFFUSE {
            let Self { frame, points, set, total, below, sent } = self;
            frame.isa.run(ExchangeOne { lobe, other, points, set, total, below, sent });
        }
    }
}

struct ExchangeOne<'a, L> {
    lobe: &'a L,
    other: &'a L,
    points: &'a Points,
    set: &'a SetPoints,
    total: &'a Column<f32>,
    below: &'a mut Column<f32>,
    sent: &'a mut Sent,
}

impl<L: Lobe> Lanewise for ExchangeOne<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { lobe, other, points, set, total, below, sent } = self;
        let (mine, theirs) = (lobe.share(), other.share());
        // Lobes of Phong look the same from everywhere.
        let is_there = theirs.is_present;
        for i in lanes(points.surfaces.len) {
            let share = mine.chance[i] / total[i];
            let chance = if lobe.is_sharp(i) { share } else { 0.0 };
            let (w, start, end) = (set.numbers[2][i], below[i], below[i] + chance);
            below[i] = end;
            let is_chosen = (w >= start) & (w < end) & is_there;
            let (from, to) = (mine.weight.get(i), theirs.weight.get(i));
            let ratio = |from: f32, to: f32| if from > 0.0 { to / from } else { 1.0 };
            let ratio = Vec3::new(ratio(from.x, to.x), ratio(from.y, to.y), ratio(from.z, to.z));
            let weight = sent.weight.get(i);
            sent.weight.set_if(i, is_chosen, weight * ratio);
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
