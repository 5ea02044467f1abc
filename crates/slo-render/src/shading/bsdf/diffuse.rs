//! Light that leaves a surface evenly in all directions.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::lobe::{At, Lobe, Sampled, Scattered, Share};
use crate::sampling::warp::cosine_power_lobe;
use crate::shading::lobe::pair;

/// Lambert's lobe; its weight is the albedo.
#[derive(Debug, Default)]
pub struct Diffuse(pub Share);

/// The density of directions that [`sample_cosine`] samples; 0 below the surface.
#[inline(always)]
pub(super) fn spread(at: &At, toward: Vec3) -> f32 {
    let density = at.n.dot(toward).max(0.0) * FRAC_1_PI;
    if at.floor.dot(toward) > 0.0 { density } else { 0.0 }
}

/// The share of light from a direction that a diffuse lobe scatters although an image bends the
/// normal: it falls to 0 evenly toward the surface instead of ending there. 1 if no image does.
///
/// Source: M. Chiang, Y. Li and B. Burley, "Taming the Shadow Terminator" (2019).
#[inline(always)]
pub(super) fn unshadowed(at: &At, toward: Vec3) -> f32 {
    let along = at.n.dot(toward) * at.n.dot(at.floor);
    let lit = (at.floor.dot(toward) / along.max(1e-6)).clamp(0.0, 1.0);
    if at.is_bent { lit * (1.0 + lit * (1.0 - lit)) } else { 1.0 }
}

/// Samples a unit direction about the shading normal, in proportion to the cosine. Also returns the
/// cosine.
#[inline(always)]
pub(super) fn sample_cosine(at: &At, u: [f32; 3]) -> (Vec3, f32) {
    let local = cosine_power_lobe([u[0], u[1]], 0.5);
    let (x, y) = pair(at.n);
    (x * local.x + y * local.y + at.n * local.z, local.z)
}

impl Lobe for Diffuse {
    const IS_DIFFUSE: bool = true;

    fn share(&self) -> &Share {
        &self.0
    }

    fn share_mut(&mut self) -> &mut Share {
        &mut self.0
    }

    #[inline(always)]
    fn evaluate(&self, i: usize, at: &At, toward: Vec3) -> Scattered {
        let density = spread(at, toward);
        let value = self.0.weight.get(i) * (density * unshadowed(at, toward));
        Scattered { value, density }
    }

    #[inline(always)]
    fn sample(&self, i: usize, at: &At, u: [f32; 3]) -> Sampled {
        let (direction, cos) = sample_cosine(at, u);
        let is_outside = at.floor.dot(direction) > 0.0;
        let weight = self.0.weight.get(i) * unshadowed(at, direction);
        let weight = if is_outside { weight } else { Vec3::ZERO };
        Sampled { direction, weight, density: cos * FRAC_1_PI }
    }
}
