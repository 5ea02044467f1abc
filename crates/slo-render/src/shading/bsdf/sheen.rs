//! Sheen: fibres that stand off a surface, like dust or velvet.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;
use slo_accel::math::columns::{BATCH, Column};

use super::diffuse::unshadowed;
use super::ggx::Frame;
use super::lobe::{At, Lobe, Sampled, Scattered, Share};
use super::sheen_nodes::{ALBEDO, NODES, SCALE, SHEAR};
use super::tables::plane;
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

/// The nodes as numbers: albedos, [`Sheen::scale`] and [`Sheen::shear`].
static TABLES: [[[f32; NODES]; NODES]; 3] = {
    let mut tables = [[[0.0; NODES]; NODES]; 3];
    let mut i = 0;
    while i < NODES * NODES {
        let (row, column) = (i / NODES, i % NODES);
        tables[0][row][column] = ALBEDO[row][column] as f32 * 1e-5;
        tables[1][row][column] = SCALE[row][column] as f32 * 1e-4;
        tables[2][row][column] = SHEAR[row][column] as f32 * 1e-4;
        i += 1;
    }
    tables
};

impl Sheen {
    /// Sets hit `i`, seen at cosine `cos` to the shading normal. Returns the albedo of white sheen.
    #[inline(always)]
    pub(super) fn set(&mut self, i: usize, roughness: f32, cos: f32) -> f32 {
        let [albedo, scale, shear] = &TABLES;
        self.scale[i] = plane(scale, cos, roughness);
        self.shear[i] = plane(shear, cos, roughness);
        plane(albedo, cos, roughness)
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
        let density = if at.floor.dot(toward) > 0.0 { density } else { 0.0 };
        let value = self.share.weight.get(i) * (density * unshadowed(at, toward));
        Scattered { value, density }
    }

    #[inline(always)]
    fn sample(&self, i: usize, at: &At, u: [f32; 3]) -> Sampled {
        let cosine = cosine_power_lobe([u[0], u[1]], 0.5);
        let (scale, shear) = (self.scale[i], self.shear[i]);
        let w = Vec3::new((cosine.x - shear * cosine.z) / scale, cosine.y / scale, cosine.z);
        let w = w * (1.0 / w.length().max(1e-20));
        let direction = Self::frame(at).to_world(w);
        let is_outside = at.floor.dot(direction) > 0.0;
        let weight = self.share.weight.get(i) * unshadowed(at, direction);
        let weight = if is_outside { weight } else { Vec3::ZERO };
        Sampled { direction, weight, density: self.density(i, w) }
    }
}
