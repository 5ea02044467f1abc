//! `lamp_sun`

use std::f64::consts::PI;

use glam::{DVec3, Vec3};

use super::bounds::LightBounds;
use super::cone;
use super::lamp::{Lamp, luminance};
use slo_scene::light;

/// Angles below this, in degrees, count as 0: unit directions in f32 resolve no smaller discs.
const LEAST_ANGLE_DEG: f32 = 1e-3;

/// The largest error of a unit direction in f32.
const DIRECTION_ERROR: f64 = 2e-7;

/// Parallel light.
#[derive(Clone, Copy, Debug)]
pub struct ParallelLamp {
    irradiance: Vec3,
    /// Unit direction toward the light.
    toward: Vec3,
}

/// Light from a disc of the sky.
#[derive(Clone, Copy, Debug)]
pub struct SunLamp {
    radiance: Vec3,
    /// Unit direction toward the middle.
    toward: Vec3,
    /// Versine of the rim.
    rim: f32,
    /// Square of the distance of the rim from `toward` on the unit sphere, with room for rounding.
    reach: f32,
    irradiance: Vec3,
}

impl ParallelLamp {
    /// Converts a lamp of the scene if it is a point of the sky.
    pub fn new(lamp: &light::SunLamp) -> Option<Self> {
        let is_point = lamp.angle_deg < LEAST_ANGLE_DEG;
        let toward = (-lamp.direction).as_vec3() + Vec3::ZERO;
        is_point.then_some(Self { irradiance: lamp.irradiance.into(), toward })
    }
}

impl SunLamp {
    /// Converts a lamp of the scene. It spans half of the sky at most.
    pub fn new(lamp: &light::SunLamp) -> Self {
        let rim =
            cone::versine_deg(f64::from(lamp.angle_deg).clamp(LEAST_ANGLE_DEG.into(), 180.0) * 0.5);
        // The square of the sine is rim (2 - rim).
        let scale = 1.0 / (PI * rim * (2.0 - rim));
        let edge = (2.0 * rim).sqrt() + DIRECTION_ERROR;
        Self {
            radiance: (DVec3::from(lamp.irradiance.map(f64::from)) * scale).as_vec3(),
            toward: (-lamp.direction).as_vec3() + Vec3::ZERO,
            rim: rim as f32,
            reach: (edge * edge) as f32,
            irradiance: lamp.irradiance.into(),
        }
    }

    #[inline(always)]
    fn is_in(&self, way: Vec3) -> bool {
        (way - self.toward).length_squared() <= self.reach
    }
}

/// Returns the bounds of light from a part of the sky whose rim has this versine.
fn sky(toward: Vec3, rim: f32, irradiance: Vec3) -> LightBounds {
    let reach = Vec3::splat((2.0 * rim).sqrt());
    LightBounds {
        falls_off: false,
        is_distant: true,
        ..LightBounds::all_round([toward - reach, toward + reach], luminance(irradiance))
    }
}

impl Lamp for ParallelLamp {
    const IS_AREA: bool = false;
    const IS_DELTA: bool = true;
    const IS_DISTANT: bool = true;

    #[inline(always)]
    fn radiance(&self, _way: Vec3) -> Vec3 {
        self.irradiance
    }

    #[inline(always)]
    fn point(&self, _from: Vec3, _u: [f32; 2]) -> Vec3 {
        self.toward
    }

    #[inline(always)]
    fn way(&self, _from: Vec3, _u: [f32; 2]) -> Vec3 {
        self.toward
    }

    #[inline(always)]
    fn density(&self, _from: Vec3, _way: Vec3) -> f32 {
        f32::INFINITY
    }

    #[inline(always)]
    fn shadow_ray(&self, _from: Vec3, point: Vec3) -> (Vec3, f32) {
        (point, f32::INFINITY)
    }

    fn bounds(&self) -> LightBounds {
        sky(self.toward, 0.0, self.irradiance)
    }
}

impl Lamp for SunLamp {
    const IS_AREA: bool = true;
    const IS_DELTA: bool = false;
    const IS_DISTANT: bool = true;

    #[inline(always)]
    fn radiance(&self, way: Vec3) -> Vec3 {
        if self.is_in(way) { self.radiance } else { Vec3::ZERO }
    }

    #[inline(always)]
    fn point(&self, from: Vec3, u: [f32; 2]) -> Vec3 {
        self.way(from, u)
    }

    /// Samples uniformly by solid angle.
    #[inline(always)]
    fn way(&self, _from: Vec3, u: [f32; 2]) -> Vec3 {
        cone::about(self.toward, self.rim, u).0
    }

    #[inline(always)]
    fn density(&self, _from: Vec3, way: Vec3) -> f32 {
        if self.is_in(way) { cone::density(self.rim) } else { 0.0 }
    }

    #[inline(always)]
    fn shadow_ray(&self, _from: Vec3, point: Vec3) -> (Vec3, f32) {
        (point, f32::INFINITY)
    }

    fn bounds(&self) -> LightBounds {
        sky(self.toward, self.rim, self.irradiance)
    }
}
