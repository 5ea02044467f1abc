//! Reflected and refracted rays from the hits of a batch.

use glam::Vec3;

use super::points::Points;
use super::queue::{Labels, Sent};
use super::roulette::{least_weight, roulette};
use super::wave::Wave;
use crate::frame::{FrameScene, Surfaces};
use crate::sampling::batch::{SetPoints, place_of};
use crate::sampling::{Purpose, Use, next_path};
use crate::shading::{MaterialTable, lobe};
use slo_accel::Lanewise;
use slo_accel::math::columns::{BATCH, Column, Vec3s, lanes, look_up};
use slo_scene::Settings;

/// Bounces that the hits of one batch of camera rays may send.
const MOST_WAITING: usize = 512 * BATCH;

/// What the hits of a batch reflect and refract, in columns.
#[derive(Debug, Default)]
pub(super) struct Lobes {
    pub(super) reflected: Lobe,
    pub(super) refracted: Lobe,
    /// Index of refraction before the surface over that behind it.
    eta: Zeros,
}

/// One lobe at every hit.
#[derive(Debug, Default)]
pub(super) struct Lobe {
    /// The perfect directions.
    pub(super) axis: Vec3s,
    /// Unit normals of the sides that the rays stay on.
    pub(super) side: Vec3s,
    /// `1 / (n + 1)`; 0: perfect.
    pub(super) inverse: Zeros,
    /// What radiance that arrives is multiplied with; 0: none is sent.
    pub(super) weight: Zeros,
}

#[derive(Debug)]
pub(super) struct Zeros(pub(super) Column<f32>);

impl Default for Zeros {
    fn default() -> Self {
        Self([0.0; BATCH])
    }
}

impl Wave {
    /// Finds the lobes of all points; false where none sends anything on.
    pub(super) fn find_lobes(&mut self, frame: &FrameScene, depth: u32) -> bool {
        let Self { points, lobes, .. } = self;
        let any = depth < frame.settings.recursion && lobes.gather(frame, points);
        if any {
            frame.isa.run(FindAxes { points, lobes });
        }
        any
    }

    /// The rays that points send on, into the queue of the next depth. `None` if told to give up.
    pub(super) fn bounce(
        &mut self,
        frame: &FrameScene,
        depth: u32,
        gives_up: &dyn Fn() -> bool,
    ) -> Option<()> {
        self.send(frame, Purpose::Reflection, depth, gives_up)?;
        self.send(frame, Purpose::Refraction, depth, gives_up)
    }

    /// Sends the rays of one lobe.
    fn send(
        &mut self,
        frame: &FrameScene,
        purpose: Purpose,
        depth: u32,
        gives_up: &dyn Fn() -> bool,
    ) -> Option<()> {
        let (glossy, perfect) = self.lobes.of(purpose).kinds(self.points.surfaces.len);
        let samples = glossy_samples(&frame.settings, purpose, depth);
        if samples == 1 || !glossy {
            if glossy || perfect {
                self.send_one(frame, purpose, [0, 1], |_| true, depth);
            }
            return Some(());
        }
        for i in 0..samples {
            if gives_up() {
                return None;
            }
            self.send_one(frame, purpose, [i, samples], |inverse| inverse > 0.0, depth);
        }
        if perfect {
            self.send_one(frame, purpose, [0, 1], |inverse| inverse == 0.0, depth);
        }
        Some(())
    }

    /// Sends ray `i` of `count` of the lobes whose `1 / (n + 1)` is wanted.
    fn send_one(
        &mut self,
        frame: &FrameScene,
        purpose: Purpose,
        [i, count]: [u32; 2],
        wanted: impl Fn(f32) -> bool,
        depth: u32,
    ) {
        self.queue_at(depth as usize + 1);
        self.draw::<3>(frame, depth, purpose, [i, count]);
        let Self { points, lobes, set, sent, chosen, bounces, next, features, .. } = self;
        let (lobe, len) = (lobes.of(purpose), points.surfaces.len);
        let least = least_weight(frame);
        let rays = if frame.combines() { count as f32 } else { 0.0 };
        let share = 1.0 / count as f32;
        frame.isa.run(Send { points, lobe, set, share, rays, least, to: sent });
        frame.isa.run(Name { points, purpose, place: [i, count], next });
        if features.are_wanted() {
            features.leave(lobe, len, next);
        }
        let goes = |i: usize| sent.weight.get(i) != Vec3::ZERO && wanted(lobe.inverse.0[i]);
        chosen.set(frame.isa, len, goes);
        bounces[depth as usize + 1].append_named(sent, next, chosen);
    }
}

/// How many rays a glossy lobe sends: as many as the settings say from a first hit, then one.
pub(super) fn glossy_samples(settings: &Settings, purpose: Purpose, depth: u32) -> u32 {
    match purpose {
        _ if depth > 0 => 1,
        Purpose::Refraction => settings.diffuse_refraction_samples,
        _ => settings.diffuse_reflection_samples,
    }
}

/// How many camera rays a batch may hold: their hits send all their rays on before any is traced.
pub(super) fn most_camera_rays(settings: &Settings) -> usize {
    let sent: usize = [Purpose::Reflection, Purpose::Refraction]
        .map(|purpose| glossy_samples(settings, purpose, 0) as usize)
        .iter()
        .sum();
    (MOST_WAITING / sent).clamp(1, BATCH)
}

impl Lobes {
    fn of(&self, purpose: Purpose) -> &Lobe {
        if purpose == Purpose::Refraction { &self.refracted } else { &self.reflected }
    }

    /// What materials say; false where no point sends anything on.
    fn gather(&mut self, frame: &FrameScene, points: &Points) -> bool {
        frame.isa.run(FromTable { table: &frame.material_table, points, to: self });
        let some = |lobe: &Lobe| lobe.weight.0[..points.surfaces.len].iter().any(|w| *w > 0.0);
        some(&self.reflected) || some(&self.refracted)
    }
}

/// Fetches what materials say of lobes.
struct FromTable<'a> {
    table: &'a MaterialTable,
    points: &'a Points,
    to: &'a mut Lobes,
}

impl Lanewise for FromTable<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { table, points, to } = self;
        let Surfaces { len, ref material, ref from_outside, .. } = points.surfaces;
        look_up(&table.reflectance, material, len, |x| x, &mut to.reflected.weight.0);
        look_up(&table.reflection_lobe, material, len, |x| x, &mut to.reflected.inverse.0);
        look_up(&table.refraction, material, len, |x| x, &mut to.refracted.weight.0);
        look_up(&table.refraction_lobe, material, len, |x| x, &mut to.refracted.inverse.0);
        look_up(&table.refraction_index, material, len, |x| x, &mut to.eta.0);
        for i in lanes(len) {
            let index = to.eta.0[i];
            to.eta.0[i] = if from_outside[i] == 1 { 1.0 / index } else { index };
        }
    }
}

impl Lobe {
    /// Whether any ray is sent by a glossy lobe, and by a perfect one.
    fn kinds(&self, len: usize) -> (bool, bool) {
        let (mut glossy, mut perfect) = (false, false);
        for (&weight, &inverse) in self.weight.0.iter().zip(&self.inverse.0).take(len) {
            glossy |= weight > 0.0 && inverse > 0.0;
            perfect |= weight > 0.0 && inverse == 0.0;
        }
        (glossy, perfect)
    }
}

/// Finds the axes of lobes, and gives what total internal reflection keeps inside to the reflected
/// ones.
struct FindAxes<'a> {
    points: &'a Points,
    lobes: &'a mut Lobes,
}

impl Lanewise for FindAxes<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        find_axes(self.points, self.lobes);
    }
}

#[inline(always)]
fn find_axes(points: &Points, lobes: &mut Lobes) {
    let surfaces = &points.surfaces;
    for i in lanes(surfaces.len) {
        let direction = points.direction.get(i);
        let (n_shade, n_geo) = (surfaces.n_shade.get(i), surfaces.n_geo.get(i));
        // An interpolated normal may look away from a ray that grazes the surface.
        let n = if n_shade.dot(direction) < 0.0 { n_shade } else { n_geo };
        let (axis, passes) = lobe::refract(direction, n, lobes.eta.0[i]);
        let refraction = lobes.refracted.weight.0[i];
        lobes.refracted.axis.set(i, axis);
        lobes.refracted.side.set(i, -n_geo);
        lobes.refracted.weight.0[i] = if passes { refraction } else { 0.0 };
        lobes.reflected.axis.set(i, lobe::reflect(direction, n_shade));
        lobes.reflected.side.set(i, n_geo);
        lobes.reflected.weight.0[i] += if passes { 0.0 } else { refraction };
    }
}

/// One ray of each lobe.
struct Send<'a> {
    points: &'a Points,
    lobe: &'a Lobe,
    set: &'a SetPoints,
    /// What one ray counts.
    share: f32,
    /// How many rays of the lobe are combined with rays to lamps.
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

/// Labels of the rays that are sent on.
struct Name<'a> {
    points: &'a Points,
    purpose: Purpose,
    /// Number of the ray, of how many.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_of_lobes_are_told_apart() {
        let mut lobe = Lobe::default();
        assert_eq!(lobe.kinds(3), (false, false));
        (lobe.weight.0[1], lobe.inverse.0[1]) = (0.5, 0.25);
        assert_eq!(lobe.kinds(3), (true, false));
        lobe.weight.0[2] = 1.0;
        assert_eq!(lobe.kinds(3), (true, true));
        assert_eq!(lobe.kinds(1), (false, false));
    }

    #[test]
    fn what_can_not_leave_is_reflected() {
        let (mut points, mut lobes) = (Points::default(), Lobes::default());
        points.surfaces.len = 2;
        for (i, sin) in [(0, 0.6f32), (1, 0.7)] {
            points.direction.set(i, Vec3::new(sin, 0.0, -(1.0 - sin * sin).sqrt()));
            points.surfaces.set_normals(i, Vec3::Z);
            lobes.refracted.weight.0[i] = 0.75;
            lobes.eta.0[i] = 1.5;
        }
        find_axes(&points, &mut lobes);
        assert_eq!(lobes.refracted.weight.0[..2], [0.75, 0.0]);
        assert_eq!(lobes.reflected.weight.0[..2], [0.0, 0.75]);
        assert!((lobes.refracted.axis.x[0] - 0.9).abs() < 1e-6);
        assert!((lobes.reflected.axis.z[1] - (0.51f32).sqrt()).abs() < 1e-6);
    }
}
