//! A sky that is the same all around.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3;

use crate::shading::light::bounds::LightBounds;
use crate::shading::light::lamp::{Lamp, luminance};
use slo_accel::math::elementary::sin_cos_turns;

/// A sky that is the same all around.
#[derive(Clone, Copy, Debug)]
pub struct EvenSky {
    radiance: Vec3,
}

impl EvenSky {
    /// A sky of this radiance.
    pub fn new(radiance: Vec3) -> Self {
        Self { radiance }
    }
}

/// Returns the bounds of a sky by the luminance of its mean radiance.
pub(super) fn bounds(luminance: f32) -> LightBounds {
    LightBounds {
        falls_off: false,
        is_distant: true,
        ..LightBounds::all_round([-Vec3::ONE, Vec3::ONE], PI * luminance)
    }
}

impl Lamp for EvenSky {
    const IS_AREA: bool = true;
    const IS_DELTA: bool = false;
    const IS_DISTANT: bool = true;

    #[inline(always)]
    fn radiance(&self, _way: Vec3) -> Vec3 {
        self.radiance
    }

    #[inline(always)]
    fn point(&self, from: Vec3, u: [f32; 2]) -> Vec3 {
        self.way(from, u)
    }

    /// Samples all directions uniformly.
    #[inline(always)]
    fn way(&self, _from: Vec3, u: [f32; 2]) -> Vec3 {
        let z = 1.0 - 2.0 * u[0];
        let sine = (1.0 - z * z).max(0.0).sqrt();
        let (s, c) = sin_cos_turns(u[1]);
        Vec3::new(sine * c, sine * s, z)
    }

    #[inline(always)]
    fn density(&self, _from: Vec3, _way: Vec3) -> f32 {
        0.25 * FRAC_1_PI
    }

    #[inline(always)]
    fn shadow_ray(&self, _from: Vec3, point: Vec3) -> (Vec3, f32) {
        (point, f32::INFINITY)
    }

    fn bounds(&self) -> LightBounds {
        bounds(luminance(self.radiance))
    }
}
