//! `lamp_rectangle`: a rectangle that glows evenly in all directions.

use glam::{DVec3, Vec3};

use super::lamp::{Lamp, expected};
use super::rectangle::Rectangle;
use slo_scene::light::{RectangleLamp as Described, RectangleLight};

/// A rectangle that glows evenly.
#[derive(Clone, Copy, Debug)]
pub struct RectangleLamp {
    surface: Rectangle,
    /// 1 if the back glows too, otherwise 0.
    back: f32,
}

impl RectangleLamp {
    /// Converts a light of the scene; `origin` is the origin of render space in scene space.
    pub fn new(light: &Described, origin: DVec3) -> Self {
        let surface = RectangleLight { color: light.radiance, rectangle: light.rectangle };
        let surface = Rectangle::new(&surface, origin);
        Self { surface, back: f32::from(u8::from(light.two_sided)) }
    }
}

impl Lamp for RectangleLamp {
    const IS_AREA: bool = true;
    const IS_DELTA: bool = false;

    #[inline(always)]
    fn radiance(&self, way: Vec3) -> Vec3 {
        let share = if way.dot(self.surface.normal) < 0.0 { 1.0 } else { self.back };
        self.surface.color * share
    }

    #[inline(always)]
    fn point(&self, from: Vec3, u: [f32; 2]) -> Vec3 {
        self.surface.point(from, u)
    }

    #[inline(always)]
    fn density(&self, way: Vec3) -> f32 {
        self.surface.density(way)
    }

    #[inline(always)]
    fn expected(&self, hit: Vec3, normals: [Vec3; 2], through: bool) -> f32 {
        self.surface.expected(hit, normals, through) + expected(Vec3::ZERO, 0.0, false)
    }

    #[inline(always)]
    fn shadow_ray(&self, from: Vec3, point: Vec3) -> (Vec3, f32) {
        self.surface.shadow_ray(from, point)
    }
}
