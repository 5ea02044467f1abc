//! Sheen: fibres that stand off a surface, like dust or velvet.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;
use slo_accel::math::columns::{BATCH, Column};
use slo_accel::math::elementary::exp2;

use super::ggx::Frame;
use super::lobe::{At, Lobe, Sampled, Scattered, Share};
use crate::sampling::warp::cosine_power_lobe;
use crate::shading::lobe::pair;

/// A cosine lobe, transformed linearly: scaled across the normal and sheared toward the eye.
///
/// Source: T. Zeltner et al., "Practical Multiple-Scattering Sheen Using Linearly Transformed
/// Cosines" (2022).
#[derive(Debug)]
pub struct Sheen {
    /// Weights include the albedo.
    pub(super) share: Share,
    /// Factor from directions to those of the cosine lobe, across the normal.
    pub(super) scale: Column<f32>,
    /// How far directions are sheared along the normal's plane, away from the eye if positive.
    pub(super) shear: Column<f32>,
}

impl Default for Sheen {
    fn default() -> Self {
        Self { share: Share::default(), scale: [1.0; BATCH], shear: [0.0; BATCH] }
    }
}

/// The least roughness and cosine that the polynomials are fitted to; values below are as there.
const LEAST: [f32; 2] = [1.0 / 6.0, 0.05];

// Polynomials in powers of x (rows) and y (columns), see `place`. They were fitted to what Blender
// 5.0.1 scatters at 26 x 23 roughnesses and cosines. The albedo is within 0.0023 of it.

/// The logarithm to base 2 of the albedo over 1 minus the albedo.
const ALBEDO: [[f32; 6]; 6] = [
    [-3.40199, -4.29424, -1.27711, -0.26898, 0.40481, -0.04047],
    [-5.39938, -5.38441, -1.15977, 0.77245, 0.87512, 0.27967],
    [-1.50610, -0.72885, 3.05386, 3.37329, -0.06638, -1.04591],
    [0.46606, 2.38683, 4.16313, 1.24218, -1.99433, -1.26317],
    [0.39956, 1.10825, -0.69313, -2.78203, -0.81221, 0.55959],
    [-0.03687, -0.24369, -1.69159, -1.82555, 0.39764, 0.82303],
];

/// See [`Sheen::scale`].
const SCALE: [[f32; 5]; 5] = [
    [0.29607, -0.21507, 0.16171, -0.16066, 0.02564],
    [0.07721, -0.05128, 0.15168, 0.06064, -0.17570],
    [-0.04673, 0.09049, 0.13791, -0.01874, -0.05866],
    [0.06106, 0.04649, -0.08144, -0.01400, 0.06653],
    [0.04795, -0.01851, -0.10745, 0.01917, 0.06414],
];

/// [`Sheen::shear`] over (1 - cosine) (1 - roughness).
const SHEAR: [[f32; 5]; 5] = [
    [-0.04041, 0.08975, -0.39373, 0.35165, -0.01262],
    [-0.07756, -0.33375, 0.41430, 0.53211, -0.56648],
    [-0.34904, 0.18686, 0.90630, -0.07794, -0.85204],
    [-0.08099, 0.17948, -0.36399, -0.05481, -0.02026],
    [0.00519, -0.19584, -0.50208, 0.29848, 0.17076],
];

/// Numbers that grow with the root of the cosine and with the smoothness, from -1 to 1.
#[inline(always)]
fn place(roughness: f32, cos: f32) -> [f32; 2] {
    const ROOT: f32 = 0.223_606_8;
    const ENDS: [f32; 2] = [1.0 / 1.1, 3.75];
    let x = cos.clamp(LEAST[1], 1.0).sqrt();
    let y = 1.0 / (roughness.clamp(LEAST[0], 1.0) + 0.1);
    [(2.0 * x - 1.0 - ROOT) / (1.0 - ROOT), (2.0 * y - ENDS[0] - ENDS[1]) / (ENDS[1] - ENDS[0])]
}

#[inline(always)]
fn polynomial<const N: usize>(of: &[[f32; N]; N], [x, y]: [f32; 2]) -> f32 {
    let mut sum = 0.0;
    for row in of.iter().rev() {
        let mut inner = 0.0;
        for coefficient in row.iter().rev() {
            inner = inner * y + coefficient;
        }
        sum = sum * x + inner;
    }
    sum
}

impl Sheen {
    /// Sets hit `i`, seen at cosine `cos` to the shading normal. Returns the albedo of white sheen.
    #[inline(always)]
    pub(super) fn set(&mut self, i: usize, roughness: f32, cos: f32) -> f32 {
        let at = place(roughness, cos);
        let (r, c) = (roughness.clamp(LEAST[0], 1.0), cos.clamp(LEAST[1], 1.0));
        self.scale[i] = polynomial(&SCALE, at).clamp(0.05, 1.0);
        self.shear[i] = (1.0 - c) * (1.0 - r) * polynomial(&SHEAR, at);
        1.0 / (1.0 + exp2(-polynomial(&ALBEDO, at)))
    }

    /// A frame about the shading normal whose x axis points toward the eye.
    #[inline(always)]
    fn frame(at: &At) -> Frame {
        let along = at.eye - at.n * at.eye.dot(at.n);
        let length = along.length();
        let x = if length > 1e-4 { along / length.max(1e-20) } else { pair(at.n).0 };
        Frame::of(x, at.n)
    }

    #[inline(always)]
    fn density(&self, i: usize, w: Vec3) -> f32 {
        let (scale, shear) = (self.scale[i], self.shear[i]);
        let (x, y) = (scale * w.x + shear * w.z, scale * w.y);
        let square = x * x + y * y + w.z * w.z;
        let density = scale * scale * w.z * FRAC_1_PI / (square * square).max(1e-20);
        if w.z > 0.0 { density } else { 0.0 }
    }
}

impl Lobe for Sheen {
    const IS_DIFFUSE: bool = true;

    fn share(&self) -> &Share {
        &self.share
    }

    fn share_mut(&mut self) -> &mut Share {
        &mut self.share
    }

    #[inline(always)]
    fn evaluate(&self, i: usize, at: &At, toward: Vec3) -> Scattered {
        let density = self.density(i, Self::frame(at).to_local(toward));
        let density = if at.n_geo.dot(toward) > 0.0 { density } else { 0.0 };
        Scattered { value: self.share.weight.get(i) * density, density }
    }

    #[inline(always)]
    fn sample(&self, i: usize, at: &At, u: [f32; 3]) -> Sampled {
        let cosine = cosine_power_lobe([u[0], u[1]], 0.5);
        let (scale, shear) = (self.scale[i], self.shear[i]);
        let w = Vec3::new((cosine.x - shear * cosine.z) / scale, cosine.y / scale, cosine.z);
        let w = w * (1.0 / w.length().max(1e-20));
        let direction = Self::frame(at).to_world(w);
        let is_outside = at.n_geo.dot(direction) > 0.0;
        let weight = if is_outside { self.share.weight.get(i) } else { Vec3::ZERO };
        Sampled { direction, weight, density: self.density(i, w) }
    }
}
