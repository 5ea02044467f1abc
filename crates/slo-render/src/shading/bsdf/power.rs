//! Phong's glossy and perfect reflection and refraction: lobes cos^n.

use glam::Vec3;
use slo_accel::math::columns::{BATCH, Column, Vec3s};

use super::lobe::{At, Lobe, SHARP, Sampled, Scattered, Share};
use crate::shading::lobe;

/// A lobe cos^n about the perfect direction, mirrored to its side of the surface; see
/// [`lobe::about`] and [`lobe::to_side`].
#[derive(Debug)]
pub struct Power {
    share: Share,
    /// Directions of perfect reflection or refraction, unit.
    pub axis: Vec3s,
    /// Unit normals of the sides that the rays stay on.
    pub side: Vec3s,
    /// `1 / (n + 1)`; 0 for a perfect lobe.
    pub inverse: Column<f32>,
    /// Index of refraction on the side of the eye divided by that on the other side, for light that is
    /// refracted.
    pub eta: Column<f32>,
}

/// The `1 / (n + 1)` of the lobe that is as wide as microfacets of width [`SHARP`]: alpha² is
/// 2 / (n + 2).
pub const SHARP_INVERSE: f32 = 0.5 * SHARP * SHARP;

impl Default for Power {
    fn default() -> Self {
        Self {
            share: Share::default(),
            axis: Vec3s::default(),
            side: Vec3s::default(),
            inverse: [0.0; BATCH],
            eta: [1.0; BATCH],
        }
    }
}

impl Lobe for Power {
    const IS_DIFFUSE: bool = false;
    const SHOWS_POINTS: bool = false;

    #[inline(always)]
    fn is_sharp(&self, i: usize) -> bool {
        self.inverse[i] < SHARP_INVERSE
    }

    #[inline(always)]
    fn of_photon(&self, i: usize, at: &At, direction: Vec3) -> f32 {
        // Phong's lobes have the same density both ways, so their values divided by the cosine differ.
        // Radiance keeps its value in refraction; the beam that it fills does not.
        let mirrored = at.n.dot(direction) / at.n.dot(at.eye);
        let passes = at.n_geo.dot(direction) < 0.0;
        if passes { self.eta[i] * self.eta[i] } else { mirrored.abs() }
    }

    fn share(&self) -> &Share {
        &self.share
    }

    fn share_mut(&mut self) -> &mut Share {
        &mut self.share
    }

    #[inline(always)]
    fn evaluate(&self, i: usize, _at: &At, toward: Vec3) -> Scattered {
        let (axis, inverse, side) = (self.axis.get(i), self.inverse[i], self.side.get(i));
        let density = lobe::density(axis, inverse, side, toward);
        let density = if side.dot(toward) > 0.0 { density } else { 0.0 };
        Scattered { value: self.share.weight.get(i) * density, density }
    }

    #[inline(always)]
    fn sample(&self, i: usize, _at: &At, u: [f32; 3]) -> Sampled {
        let (axis, inverse, side) = (self.axis.get(i), self.inverse[i], self.side.get(i));
        let direction = lobe::to_side(lobe::about(axis, inverse, [u[0], u[1]]), side);
        let density = lobe::density(axis, inverse, side, direction);
        Sampled { direction, weight: self.share.weight.get(i), density }
    }
}
