//! `lamp_point` and `lamp_spot` with a radius.

use std::f32::consts::PI;

use glam::{DVec3, Vec3};

use super::bounds::LightBounds;
use super::cone::{self, Beam};
use super::lamp::Lamp;
use super::lamp_point::{in_beam, intensity};
use slo_accel::math::rounding::gamma;
use slo_scene::light;

/// A sphere that glows on its outside, in all directions or in those of a cone.
#[derive(Clone, Copy, Debug)]
pub struct SphereLamp {
    radiance: Vec3,
    center: Vec3,
    radius: f32,
    beam: Beam,
}

impl SphereLamp {
    /// Converts a lamp of the scene; `origin` is the origin of render space in scene space.
    pub fn point(lamp: &light::PointLamp, origin: DVec3) -> Self {
        let intensity = intensity(lamp.power, 2.0);
        Self::new(intensity, lamp.position - origin, lamp.radius, Beam::ALL)
    }

    /// Converts a lamp of the scene; `origin` is the origin of render space in scene space.
    pub fn spot(lamp: &light::SpotLamp, origin: DVec3) -> Self {
        let (beam, rim) = Beam::cone(lamp.axis, lamp.angle_deg, lamp.blend);
        Self::new(intensity(lamp.power, rim), lamp.position - origin, lamp.radius, beam)
    }

    /// A sphere in render space that glows evenly in all directions.
    pub fn even(center: Vec3, radius: f32, radiance: Vec3) -> Self {
        Self { radiance, center, radius, beam: Beam::ALL }
    }

    fn new(intensity: Vec3, center: DVec3, radius: f64, beam: Beam) -> Self {
        let radius = radius as f32;
        let radiance = intensity / (PI * radius * radius);
        Self { radiance, center: center.as_vec3(), radius, beam }
    }

    /// Returns the vector from a hit to the centre, its length, and the versine of the cone that
    /// the sphere subtends: 1 if the hit lies inside, or so close to the surface that rounding decides.
    #[inline(always)]
    fn cap(&self, from: Vec3) -> (Vec3, f32, f32) {
        let way = self.center - from;
        let square = way.length_squared().max(f32::MIN_POSITIVE);
        let far = (from.abs() + self.center.abs() + self.radius).max_element();
        let reach = self.radius + gamma(64) * far;
        let sin2 = self.radius * self.radius / square;
        let sin2 = if square <= reach * reach { 1.0 } else { sin2 };
        (way, square.sqrt(), sin2 / (1.0 + (1.0 - sin2).sqrt()))
    }
}

impl Lamp for SphereLamp {
    const IS_AREA: bool = true;
    const IS_DELTA: bool = false;
    const IS_CLOSED: bool = true;

    #[inline(always)]
    fn radiance(&self, way: Vec3) -> Vec3 {
        self.radiance * self.beam.share(way * (-1.0 / way.length().max(f32::MIN_POSITIVE)))
    }

    #[inline(always)]
    fn point(&self, from: Vec3, u: [f32; 2]) -> Vec3 {
        from + self.way(from, u)
    }

    /// Samples uniformly by solid angle.
    #[inline(always)]
    fn way(&self, from: Vec3, u: [f32; 2]) -> Vec3 {
        let (way, distance, rim) = self.cap(from);
        let (direction, versine) = cone::about(way * (1.0 / distance), rim, u);
        let across2 = distance * distance * (versine * (2.0 - versine));
        let inside = (self.radius * self.radius - across2).max(0.0).sqrt();
        let length = distance * (1.0 - versine) - inside;
        // From inside there is no way to the outside, and any will do.
        direction * if rim < 1.0 { length.max(f32::MIN_POSITIVE) } else { self.radius }
    }

    #[inline(always)]
    fn density(&self, from: Vec3, _way: Vec3) -> f32 {
        let (_, _, rim) = self.cap(from);
        if rim < 1.0 { cone::density(rim) } else { f32::INFINITY }
    }

    /// The ray ends where it enters a sphere that is larger by the rounding errors of the point, of
    /// the direction and of the sphere's intersection test, so that a ray along the sphere's side
    /// does not hit it either.
    #[inline(always)]
    fn shadow_ray(&self, from: Vec3, point: Vec3) -> (Vec3, f32) {
        let direction = point - from;
        let way = self.center - from;
        let inverse = 1.0 / direction.length_squared().max(f32::MIN_POSITIVE);
        let nearest = way.dot(direction) * inverse;
        let far = from.abs() + self.center.abs() + self.radius;
        let radius = self.radius + gamma(32) * far.max_element();
        let across2 = (way - direction * nearest).length_squared();
        let half = ((radius * radius - across2).max(0.0) * inverse).sqrt();
        (direction, (nearest - half).clamp(0.5, 1.0))
    }

    fn encloses(&self, point: Vec3) -> bool {
        (point - self.center).length_squared() < self.radius * self.radius
    }

    fn area(&self) -> f32 {
        4.0 * PI * self.radius * self.radius
    }

    fn place(&self, u: [f32; 2]) -> Vec3 {
        self.center + cone::about(Vec3::Z, 2.0, u).0 * self.radius
    }

    fn normal(&self, point: Vec3) -> Vec3 {
        (point - self.center).normalize_or(Vec3::Z)
    }

    fn bounds(&self) -> LightBounds {
        let intensity = self.radiance * (PI * self.radius * self.radius);
        in_beam([self.center - self.radius, self.center + self.radius], &self.beam, intensity)
    }
}
