//! A triangle of a surface that emits light.

use glam::{DVec3, Vec3};

use super::bounds::LightBounds;
use super::flat;
use super::lamp::{Lamp, luminance};

/// A triangle that glows evenly in all directions, on both sides.
#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    radiance: Vec3,
    /// First corner.
    corner: Vec3,
    /// From the first corner to the others.
    sides: [Vec3; 2],
    /// Unit normal.
    normal: Vec3,
    area: f32,
}

impl Triangle {
    /// A triangle in render space. One without an area is never chosen.
    pub fn new([a, b, c]: [Vec3; 3], radiance: Vec3) -> Self {
        let cross = (b - a).as_dvec3().cross((c - a).as_dvec3());
        let normal = cross.normalize_or(DVec3::Z).as_vec3();
        let area = (0.5 * cross.length()) as f32;
        Self { radiance, corner: a, sides: [b - a, c - a], normal, area }
    }
}

impl Lamp for Triangle {
    const IS_AREA: bool = true;
    const IS_DELTA: bool = false;

    #[inline(always)]
    fn radiance(&self, _way: Vec3) -> Vec3 {
        self.radiance
    }

    /// Samples uniformly by area.
    ///
    /// Source: E. Heitz, "A Low-Distortion Map Between Triangle and Square" (2019).
    #[inline(always)]
    fn point(&self, _from: Vec3, [x, y]: [f32; 2]) -> Vec3 {
        let half = 0.5 * x.min(y);
        let (a, b) = if y > x { (half, y - half) } else { (x - half, half) };
        self.corner + self.sides[0] * a + self.sides[1] * b
    }

    #[inline(always)]
    fn density(&self, _from: Vec3, way: Vec3) -> f32 {
        flat::density(way, self.normal, self.area)
    }

    #[inline(always)]
    fn shadow_ray(&self, from: Vec3, point: Vec3) -> (Vec3, f32) {
        let size = self.sides[0].abs() + self.sides[1].abs();
        flat::shadow_ray(from, point, self.normal, self.corner, size)
    }

    fn area(&self) -> f32 {
        self.area
    }

    fn normal(&self, _point: Vec3) -> Vec3 {
        self.normal
    }

    fn bounds(&self) -> LightBounds {
        let corners = [self.corner, self.corner + self.sides[0], self.corner + self.sides[1]];
        let energy = luminance(self.radiance) * self.area;
        LightBounds::flat(&corners, self.normal, true, energy)
    }
}
