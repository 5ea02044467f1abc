//! Rays of the lobes of a batch of hits.

use glam::Vec3;
use slo_accel::Lanewise;
use slo_accel::math::columns::lanes;

use super::lobes::{Lobe, Lobes};
use super::points::Points;
use crate::frame::FrameScene;
use crate::integrator::batch::{Labels, Sent};
use crate::integrator::branching::glossy_samples;
use crate::integrator::chosen::Chosen;
use crate::integrator::roulette::{least_weight, roulette};
use crate::sampling::batch::{SetPoints, place_of};
use crate::sampling::{Purpose, Use, next_path};
use crate::shading::lobe;

/// One ray from every point whose lobe is wanted.
#[derive(Clone, Copy, Debug)]
pub(in crate::integrator) struct Bounce {
    /// The lobe.
    purpose: Purpose,
    wanted: Wanted,
    /// Number of the ray, and the number of rays.
    place: [u32; 2],
}

/// Lobes that send a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wanted {
    All,
    Glossy,
    Perfect,
}

/// Returns the bounces of all points: several rays of each glossy lobe at first hits, and one ray
/// of each perfect lobe.
pub(in crate::integrator) fn bounces(
    frame: &FrameScene,
    lobes: &Lobes,
    points: &Points,
    depth: u32,
) -> impl Iterator<Item = Bounce> {
    let (settings, len) = (&frame.settings, points.len());
    [Purpose::Reflection, Purpose::Refraction].into_iter().flat_map(move |purpose| {
        let (glossy, perfect) = lobes.of(purpose).kinds(len);
        let samples = glossy_samples(settings, purpose, depth);
        let splits = samples > 1 && glossy;
        let one = match (splits, perfect || glossy) {
            (true, _) => perfect.then_some(Wanted::Perfect),
            (false, any) => any.then_some(Wanted::All),
        };
        let several = (0..if splits { samples } else { 0 }).map(move |i| Bounce {
            purpose,
            wanted: Wanted::Glossy,
            place: [i, samples],
        });
        several.chain(one.map(|wanted| Bounce { purpose, wanted, place: [0, 1] }))
    })
}

/// Rays of one bounce from all points.
#[derive(Debug, Default)]
pub(in crate::integrator) struct Scattering {
    set: SetPoints,
    pub(in crate::integrator) sent: Sent,
    pub(in crate::integrator) labels: Labels,
    /// Points that send a ray.
    pub(in crate::integrator) chosen: Chosen,
}

impl Scattering {
    /// Creates the rays of one bounce. If surface features are collected, `first_behind` is the
    /// first slot of light through rough lobes.
    pub(in crate::integrator) fn send(
        &mut self,
        frame: &FrameScene,
        points: &Points,
        lobes: &Lobes,
        Bounce { purpose, wanted, place }: Bounce,
        depth: u32,
        first_behind: Option<u32>,
    ) {
        let Self { set, sent, labels, chosen } = self;
        let names = points.names(&frame.settings, depth, purpose, place);
        set.take::<3>(&frame.sampler, frame.isa, &names);
        let (lobe, len, count) = (lobes.of(purpose), points.len(), place[1] as f32);
        let least = least_weight(frame);
        let rays = if frame.combines() { count } else { 0.0 };
        frame.isa.run(Send { points, lobe, set, share: 1.0 / count, rays, least, to: sent });
        frame.isa.run(Name { points, purpose, place, next: labels });
        if let Some(first) = first_behind {
            leave_features(lobe, &mut labels.slot[..len], first);
        }
        let sends = |i: usize| sent.weight.get(i) != Vec3::ZERO;
        match wanted {
            Wanted::All => chosen.set(frame.isa, len, sends),
            Wanted::Glossy => {
                chosen.set(frame.isa, len, |i| sends(i) && lobe.inverse.0[i] > 0.0);
            }
            Wanted::Perfect => {
                chosen.set(frame.isa, len, |i| sends(i) && lobe.inverse.0[i] == 0.0);
            }
        }
    }
}

/// Moves rays of rough lobes to the slots of light through a rough lobe.
fn leave_features(lobe: &Lobe, slots: &mut [u32], first_behind: u32) {
    for (slot, inverse) in slots.iter_mut().zip(&lobe.inverse.0) {
        if *inverse > 0.0 && *slot < first_behind {
            *slot += first_behind;
        }
    }
}

/// Creates one ray of each lobe.
struct Send<'a> {
    points: &'a Points,
    lobe: &'a Lobe,
    set: &'a SetPoints,
    /// Share of one ray in the light of the lobe.
    share: f32,
    /// Number of rays of the lobe that are combined with rays to lamps; 0 if none are.
    rays: f32,
    /// See [`roulette`].
    least: f32,
    to: &'a mut Sent,
}

impl Lanewise for Send<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { points, lobe, set, share, rays, least, to } = self;
        send(points, lobe, set, [share, rays, least], to);
    }
}

#[inline(always)]
fn send(
    points: &Points,
    lobe: &Lobe,
    set: &SetPoints,
    [share, rays, least]: [f32; 3],
    to: &mut Sent,
) {
    let surfaces = &points.surfaces;
    for i in lanes(surfaces.len) {
        let u = [set.numbers[0][i], set.numbers[1][i]];
        let (axis, inverse, side) = (lobe.axis.get(i), lobe.inverse.0[i], lobe.side.get(i));
        let direction = lobe::to_side(lobe::about(axis, inverse, u), side);
        to.origin.set(i, surfaces.leave(i, direction));
        to.direction.set(i, direction);
        to.t_max[i] = f32::INFINITY;
        to.density[i] = rays * lobe::density(axis, inverse, side, direction);
        let weight = points.weight.get(i) * (lobe.weight.0[i] * share);
        let weight = roulette(weight, least, set.numbers[2][i]);
        to.weight.set(i, if to.is_ray(i) { weight } else { Vec3::ZERO });
    }
}

/// Sets the labels of the rays.
struct Name<'a> {
    points: &'a Points,
    purpose: Purpose,
    /// Number of the ray, and the number of rays.
    place: [u32; 2],
    next: &'a mut Labels,
}

impl Lanewise for Name<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        name(self.points, self.purpose.into(), self.place, self.next);
    }
}

#[inline(always)]
fn name(points: &Points, branch: Use, place: [u32; 2], next: &mut Labels) {
    let labels = &points.labels;
    for i in lanes(points.surfaces.len) {
        next.time[i] = labels.time[i];
        next.slot[i] = labels.slot[i];
        next.path[i] = next_path(labels.path[i], branch);
        next.index[i] = place_of(labels.index[i], place);
    }
}
