//! `light_point`: a light without an area.

use std::f32::consts::PI;

use glam::{DVec3, Vec3};

use super::bounds::LightBounds;
use super::lamp::{Lamp, luminance};
use slo_scene::light::PointLight;

/// A point.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Radiance that reaches a hit, at any distance (lights have no falloff).
    pub(super) color: Vec3,
    pub(super) position: Vec3,
}

impl Point {
    /// Converts a light of the scene; `origin` is the origin of render space in scene space.
    pub fn new(light: &PointLight, origin: DVec3) -> Self {
        let position = (light.position - origin).as_vec3();
        // Adding 0 turns -0 into 0, so rays do not depend on the sign of a zero.
        Self { color: light.color.into(), position: position + Vec3::ZERO }
    }
}

impl Lamp for Point {
    const IS_AREA: bool = false;
    const IS_DELTA: bool = true;
    const IS_OF_THESIS: bool = true;

    #[inline(always)]
    fn radiance(&self, _way: Vec3) -> Vec3 {
        self.color
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
        let energy = PI * luminance(self.color);
        LightBounds { falls_off: false, ..LightBounds::all_round([self.position; 2], energy) }
    }
}
