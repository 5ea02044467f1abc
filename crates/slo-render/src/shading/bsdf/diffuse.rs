//! Light that leaves a surface evenly in all directions.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::lobe::{At, Lobe, Sampled, Scattered, Share};
use crate::sampling::warp::cosine_power_lobe;
use crate::shading::lobe::pair;

/// Lambert's lobe; its weight is the albedo.
#[derive(Debug, Default)]
pub struct Diffuse(pub Share);

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
        let density = at.n.dot(toward).max(0.0) * FRAC_1_PI;
        let density = if at.n_geo.dot(toward) > 0.0 { density } else { 0.0 };
        Scattered { value: self.0.weight.get(i) * density, density }
    }

    #[inline(always)]
    fn sample(&self, i: usize, at: &At, u: [f32; 3]) -> Sampled {
        let local = cosine_power_lobe([u[0], u[1]], 0.5);
        let (x, y) = pair(at.n);
        let direction = x * local.x + y * local.y + at.n * local.z;
        let is_outside = at.n_geo.dot(direction) > 0.0;
        let weight = if is_outside { self.0.weight.get(i) } else { Vec3::ZERO };
        Sampled { direction, weight, density: local.z * FRAC_1_PI }
    }
}
