//! Light that a rough matt surface scatters, as Blender has it.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3;
use slo_accel::math::columns::{BATCH, Column, Vec3s};

use super::diffuse::{sample_cosine, spread, unshadowed};
use super::lobe::{At, Lobe, Sampled, Scattered, Share};

/// Fujii's Oren-Nayar model and the light that is scattered several times; its weight contains the
/// colour of the surface.
///
/// Blender's light of several scatterings is that of the EON model (Portsmouth, Kutz and Hill 2025)
/// times the colour once more: a grey of 0.8 returns 0.7312 where EON returns 0.7587.
#[derive(Debug)]
pub struct RoughDiffuse {
    pub(super) share: Share,
    /// Roughness, 0 to 1.
    pub(super) roughness: Column<f32>,
    /// What light of several scatterings has to do with the colour and the eye.
    pub(super) multiple: Vec3s,
}

impl Default for RoughDiffuse {
    fn default() -> Self {
        Self { share: Share::default(), roughness: [0.0; BATCH], multiple: Vec3s::default() }
    }
}

/// The share of light of one scattering by a white surface that is not lost by the model's scale.
#[inline(always)]
fn scale(roughness: f32) -> f32 {
    1.0 / (1.0 + (0.5 - 2.0 / (3.0 * PI)) * roughness)
}

/// The directional albedo of one scattering by a white surface, at cosine `cos`.
///
/// The exact term, (sin (acos cos - sin cos) + 2/3 (sin (1 - sin³) / cos - sin)) / pi, is replaced
/// by a polynomial that is within 0.0003 of it.
#[inline(always)]
fn single(roughness: f32, cos: f32) -> f32 {
    let x = 1.0 - cos.clamp(0.0, 1.0);
    let term = x
        * (0.041_423_94 + x * (0.635_157 + x * (-0.753_017 + x * (0.566_466_6 - 0.202_461_9 * x))));
    scale(roughness) * (1.0 + roughness * term)
}

/// The mean of [`single`] over all directions, weighted by the cosine.
#[inline(always)]
fn mean(roughness: f32) -> f32 {
    scale(roughness) * (1.0 + (2.0 / 3.0 - 28.0 / (15.0 * PI)) * roughness)
}

impl RoughDiffuse {
    /// Sets hit `i`, seen at cosine `cos`. Returns the albedo, without the weight.
    #[inline(always)]
    pub(super) fn set(&mut self, i: usize, color: Vec3, roughness: f32, cos: f32) -> Vec3 {
        let (mean, seen) = (mean(roughness), single(roughness, cos));
        // Nothing is lost if the roughness is 0.
        let lost = (1.0 - mean).max(1e-6);
        let multiple = color * color * (mean * (1.0 - seen) / lost)
            / (Vec3::ONE - color * lost).max(Vec3::splat(1e-3));
        self.roughness[i] = roughness;
        self.multiple.set(i, multiple);
        multiple * lost + seen
    }

    /// BSDF times pi, without the weight, for unit directions above the surface.
    #[inline(always)]
    fn relative(&self, i: usize, at: &At, toward: Vec3) -> Vec3 {
        let roughness = self.roughness[i];
        let (eye, light) = (at.n.dot(at.eye).max(0.0), at.n.dot(toward).max(0.0));
        let s = at.eye.dot(toward) - eye * light;
        let t = if s > 0.0 { eye.max(light).max(1e-6) } else { 1.0 };
        let once = scale(roughness) * (1.0 + roughness * s / t);
        self.multiple.get(i) * (1.0 - single(roughness, light)) + once.max(0.0)
    }
}

impl Lobe for RoughDiffuse {
    const IS_DIFFUSE: bool = true;

    fn share(&self) -> &Share {
        &self.share
    }

    fn share_mut(&mut self) -> &mut Share {
        &mut self.share
    }

    #[inline(always)]
    fn evaluate(&self, i: usize, at: &At, toward: Vec3) -> Scattered {
        let density = spread(at, toward);
        let lit = density * unshadowed(at, toward);
        let value = self.share.weight.get(i) * self.relative(i, at, toward) * lit;
        Scattered { value, density }
    }

    #[inline(always)]
    fn sample(&self, i: usize, at: &At, u: [f32; 3]) -> Sampled {
        let (direction, cos) = sample_cosine(at, u);
        let weight = self.share.weight.get(i) * self.relative(i, at, direction);
        let weight = weight * unshadowed(at, direction);
        let is_outside = at.floor.dot(direction) > 0.0;
        let weight = if is_outside { weight } else { Vec3::ZERO };
        Sampled { direction, weight, density: cos * FRAC_1_PI }
    }
}
