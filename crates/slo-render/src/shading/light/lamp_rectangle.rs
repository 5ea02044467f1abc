//! `lamp_rectangle`: a rectangle that glows evenly in all directions.

use glam::{DVec3, Vec3};

use super::bounds::LightBounds;
use super::flat;
use super::lamp::{Lamp, luminance};
use super::rectangle::Rectangle;
use super::spherical_rectangle::SphericalRectangle;
use slo_accel::math::columns::select;
use slo_scene::light::{RectangleLamp as Described, RectangleLight};

/// Cosine between the sides past which a rectangle is none.
const RIGHT_ANGLE: f64 = 1e-5;

/// A rectangle that glows evenly.
#[derive(Clone, Copy, Debug)]
pub struct RectangleLamp {
    surface: Rectangle,
    /// 1 if the back glows too, otherwise 0.
    back: f32,
    /// 1 over the sum of two sides; not a number if they are at no right angle.
    scale: f32,
    /// Lengths of the sides in units of their sum.
    size: [f32; 2],
    /// What makes products with a side a coordinate along it, in units of the sum.
    along: [f32; 2],
}

impl RectangleLamp {
    /// Converts a light of the scene; `origin` is the origin of render space in scene space.
    pub fn new(light: &Described, origin: DVec3) -> Self {
        let [v0, v1, v2] = light.rectangle.vertices;
        let surface = RectangleLight { color: light.radiance, rectangle: light.rectangle };
        let surface = Rectangle::new(&surface, origin);
        let lengths = [(v1 - v0).length(), (v2 - v1).length()];
        let is_right = (v1 - v0).dot(v2 - v1).abs() <= RIGHT_ANGLE * lengths[0] * lengths[1];
        let scale = if is_right { 1.0 / (lengths[0] + lengths[1]) } else { f64::NAN };
        Self {
            surface,
            back: f32::from(u8::from(light.two_sided)),
            scale: scale as f32,
            size: lengths.map(|length| (length * scale) as f32),
            along: lengths.map(|length| (scale / length) as f32),
        }
    }

    /// The rectangle as seen from a hit.
    #[inline(always)]
    fn seen(&self, from: Vec3) -> SphericalRectangle {
        let Rectangle { corner, sides, normal, .. } = self.surface;
        let way = corner - from;
        let [x, y] = [0, 1].map(|k| way.dot(sides[k]) * self.along[k]);
        SphericalRectangle::new(x, y, way.dot(normal) * self.scale, self.size)
    }
}

impl Lamp for RectangleLamp {
    const IS_AREA: bool = true;
    const IS_DELTA: bool = false;

    #[inline(always)]
    fn radiance(&self, way: Vec3) -> Vec3 {
        self.surface.color * flat::side(way, self.surface.normal, self.back)
    }

    /// Samples uniformly by solid angle, or by area where the solid angle is small.
    #[inline(always)]
    fn point(&self, from: Vec3, u: [f32; 2]) -> Vec3 {
        let seen = self.seen(from);
        // Sampled in any case, so that loops have no branches.
        let (is_large, sampled) = (seen.is_large(), seen.sample(u));
        let shares = [0, 1].map(|k| select(is_large, sampled[k], u[k]));
        self.surface.point(from, shares)
    }

    #[inline(always)]
    fn density(&self, from: Vec3, way: Vec3) -> f32 {
        let seen = self.seen(from);
        if seen.is_large() { seen.density() } else { self.surface.density(from, way) }
    }

    #[inline(always)]
    fn shadow_ray(&self, from: Vec3, point: Vec3) -> (Vec3, f32) {
        self.surface.shadow_ray(from, point)
    }

    fn area(&self) -> f32 {
        self.surface.area
    }

    fn normal(&self, _point: Vec3) -> Vec3 {
        self.surface.normal
    }

    fn bounds(&self) -> LightBounds {
        let Rectangle { color, normal, area, .. } = self.surface;
        let corners = self.surface.corners();
        LightBounds::flat(&corners, normal, self.back > 0.0, luminance(color) * area)
    }
}
