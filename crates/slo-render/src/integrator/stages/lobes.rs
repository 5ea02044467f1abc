//! The reflected and refracted lobes of a batch of hits.

use slo_accel::Lanewise;
use slo_accel::math::columns::{BATCH, Column, Vec3s, lanes, look_up};

use super::points::Points;
use crate::frame::{FrameScene, Surfaces};
use crate::sampling::Purpose;
use crate::shading::{MaterialTable, lobe};

/// The lobes of a batch of hits, in columns.
#[derive(Debug, Default)]
pub(in crate::integrator) struct Lobes {
    pub(super) reflected: Lobe,
    pub(super) refracted: Lobe,
    /// Index of refraction on the incident side divided by the index on the other side.
    eta: Zeros,
}

/// One lobe at every hit.
#[derive(Debug, Default)]
pub(in crate::integrator) struct Lobe {
    /// Directions of perfect reflection or refraction, unit.
    pub(super) axis: Vec3s,
    /// Unit normals of the sides that the rays stay on.
    pub(super) side: Vec3s,
    /// `1 / (n + 1)` of the lobe cos^n; 0 for a perfect lobe.
    pub(super) inverse: Zeros,
    /// Share of the radiance that arrives through the lobe; if it is 0, no ray is sent.
    pub(super) weight: Zeros,
}

#[derive(Debug)]
pub(super) struct Zeros(pub(super) Column<f32>);

impl Default for Zeros {
    fn default() -> Self {
        Self([0.0; BATCH])
    }
}

impl Lobes {
    /// Returns the lobe of rays of a purpose.
    pub(in crate::integrator) fn of(&self, purpose: Purpose) -> &Lobe {
        if purpose == Purpose::Refraction { &self.refracted } else { &self.reflected }
    }

    /// Finds the lobes of all points. Returns false if none reflects or refracts light.
    pub(in crate::integrator) fn find(&mut self, frame: &FrameScene, points: &Points) -> bool {
        frame.isa.run(FromTable { table: &frame.material_table, points, to: self });
        let some = |lobe: &Lobe| lobe.weight.0[..points.surfaces.len].iter().any(|w| *w > 0.0);
        let any = some(&self.reflected) || some(&self.refracted);
        if any {
            frame.isa.run(FindAxes { points, lobes: self });
        }
        any
    }
}

/// Looks up the lobes of materials.
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
    /// Returns whether any glossy lobe sends a ray, and whether any perfect lobe does.
    pub(super) fn kinds(&self, len: usize) -> (bool, bool) {
        let (mut glossy, mut perfect) = (false, false);
        for (&weight, &inverse) in self.weight.0.iter().zip(&self.inverse.0).take(len) {
            glossy |= weight > 0.0 && inverse > 0.0;
            perfect |= weight > 0.0 && inverse == 0.0;
        }
        (glossy, perfect)
    }
}

/// Computes the axes of lobes, and moves totally reflected light from the refracted to the
/// reflected lobe.
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
        // An interpolated normal may face away from a ray that grazes the surface.
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

#[cfg(test)]
mod tests {
    use glam::Vec3;

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
    fn total_internal_reflection() {
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
