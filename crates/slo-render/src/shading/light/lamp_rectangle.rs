//! `lamp_rectangle`: a rectangle that glows evenly in all directions.

use glam::{DVec3, Vec3};

use super::bounds::LightBounds;
use super::flat;
use super::lamp::{Lamp, luminance};
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
        self.surface.color * flat::side(way, self.surface.normal, self.back)
    }

    #[inline(always)]
    fn point(&self, from: Vec3, u: [f32; 2]) -> Vec3 {
        self.surface.point(from, u)
    }

    #[inline(always)]
    fn density(&self, from: Vec3, way: Vec3) -> f32 {
        self.surface.density(from, way)
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
