//! `lamp_disc`

use std::f32::consts::PI;

use glam::{DVec3, Vec3};

use super::bounds::LightBounds;
use super::flat;
use super::lamp::{Lamp, luminance};
use crate::sampling::warp::concentric_disc;
use crate::shading::lobe::pair;
use slo_scene::light;

/// A disc that glows evenly in all directions.
#[derive(Clone, Copy, Debug)]
pub struct DiscLamp {
    radiance: Vec3,
    center: Vec3,
    /// Two radii at a right angle.
    radii: [Vec3; 2],
    /// Unit normal of the front.
    normal: Vec3,
    area: f32,
    /// 1 if the back glows too, otherwise 0.
    back: f32,
}

impl DiscLamp {
    /// Converts a lamp of the scene; `origin` is the origin of render space in scene space.
    pub fn new(lamp: &light::DiscLamp, origin: DVec3) -> Self {
        let radius = lamp.radius as f32;
        let normal = lamp.normal.as_vec3();
        let (x, y) = pair(normal);
        Self {
            radiance: lamp.radiance.into(),
            center: (lamp.center - origin).as_vec3(),
            radii: [x * radius, y * radius],
            normal,
            area: PI * radius * radius,
            back: f32::from(u8::from(lamp.two_sided)),
        }
    }
}

impl Lamp for DiscLamp {
    const IS_AREA: bool = true;
    const IS_DELTA: bool = false;

    #[inline(always)]
    fn radiance(&self, way: Vec3) -> Vec3 {
        self.radiance * flat::side(way, self.normal, self.back)
    }

    /// Samples uniformly by area.
    #[inline(always)]
    fn point(&self, _from: Vec3, u: [f32; 2]) -> Vec3 {
        let [a, b] = concentric_disc(u);
        self.center + self.radii[0] * a + self.radii[1] * b
    }

    #[inline(always)]
    fn density(&self, _from: Vec3, way: Vec3) -> f32 {
        flat::density(way, self.normal, self.area)
    }

    #[inline(always)]
    fn shadow_ray(&self, from: Vec3, point: Vec3) -> (Vec3, f32) {
        let size = self.radii[0].abs() + self.radii[1].abs();
        flat::shadow_ray(from, point, self.normal, self.center, size)
    }

    fn area(&self) -> f32 {
        self.area
    }

    fn normal(&self, _point: Vec3) -> Vec3 {
        self.normal
    }

    fn bounds(&self) -> LightBounds {
        let [x, y] = self.radii;
        // A disc reaches as far along an axis as the two radii together.
        let reach = (x * x + y * y).map(f32::sqrt);
        let corners = [self.center - reach, self.center + reach];
        let energy = luminance(self.radiance) * self.area;
        LightBounds::flat(&corners, self.normal, self.back > 0.0, energy)
    }
}
