//! `lamp_point` and `lamp_spot` without a radius.

use std::f64::consts::TAU;

use glam::{DVec3, Vec3};

use super::bounds::LightBounds;
use super::cone::Beam;
use super::lamp::{Lamp, luminance};
use slo_scene::light;

/// A point that shines all round, or into a cone.
#[derive(Clone, Copy, Debug)]
pub struct PointLamp {
    /// W/sr
    intensity: Vec3,
    position: Vec3,
    beam: Beam,
}

impl PointLamp {
    /// Converts a lamp of the scene; `origin` is the origin of render space in scene space.
    pub fn point(lamp: &light::PointLamp, origin: DVec3) -> Self {
        let intensity = intensity(lamp.power, 2.0);
        Self::new(intensity, lamp.position - origin, Beam::ALL)
    }

    /// Converts a lamp of the scene; `origin` is the origin of render space in scene space.
    pub fn spot(lamp: &light::SpotLamp, origin: DVec3) -> Self {
        let (beam, rim) = Beam::cone(lamp.axis, lamp.angle_deg, lamp.blend);
        Self::new(intensity(lamp.power, rim), lamp.position - origin, beam)
    }

    fn new(intensity: Vec3, position: DVec3, beam: Beam) -> Self {
        // Adding 0 turns -0 into 0, so rays do not depend on the sign of a zero.
        Self { intensity, position: position.as_vec3() + Vec3::ZERO, beam }
    }
}

/// Returns the intensity of a lamp that sends its power evenly into a cone whose rim has this
/// versine.
pub(super) fn intensity(power: [f32; 3], rim: f64) -> Vec3 {
    (DVec3::from(power.map(f64::from)) / (TAU * rim)).as_vec3()
}

/// Returns the bounds of a lamp that shines into a beam from within a box.
pub(super) fn in_beam(about: [Vec3; 2], beam: &Beam, intensity: Vec3) -> LightBounds {
    let (axis, spread) = beam.bounds();
    LightBounds { axis, spread, ..LightBounds::all_round(about, luminance(intensity)) }
}

impl Lamp for PointLamp {
    const IS_AREA: bool = false;
    const IS_DELTA: bool = true;

    #[inline(always)]
    fn radiance(&self, way: Vec3) -> Vec3 {
        let inverse = 1.0 / way.length_squared().max(f32::MIN_POSITIVE);
        let share = self.beam.share(way * -inverse.sqrt());
        self.intensity * (share * inverse)
    }

    #[inline(always)]
    fn point(&self, _from: Vec3, _u: [f32; 2]) -> Vec3 {
        self.position
    }

    #[inline(always)]
    fn density(&self, _from: Vec3, _way: Vec3) -> f32 {
        f32::INFINITY
    }

    #[inline(always)]
    fn shadow_ray(&self, from: Vec3, point: Vec3) -> (Vec3, f32) {
        (point - from, 1.0)
    }

    fn bounds(&self) -> LightBounds {
        in_beam([self.position; 2], &self.beam, self.intensity)
    }
}
