//! The reflection of a dielectric over a diffuse base.

use glam::Vec3;
use slo_accel::math::columns::{BATCH, Column, Vec3s};

use super::facets::Facets;
use super::fresnel::between;
use super::lobe::{At, Lobe, Sampled, Scattered, Share};

/// Microfacets that reflect `f0` along the normal and all light at grazing angles, and between as
/// a dielectric does.
#[derive(Debug)]
pub struct Specular {
    pub(super) facets: Facets,
    /// Shares of light that are reflected along the normal.
    pub(super) f0: Vec3s,
    /// Indices of refraction.
    pub(super) eta: Column<f32>,
}

impl Default for Specular {
    fn default() -> Self {
        Self { facets: Facets::default(), f0: Vec3s::default(), eta: [1.0; BATCH] }
    }
}

impl Specular {
    #[inline(always)]
    fn fresnel(&self, i: usize) -> impl Fn(f32) -> Vec3 {
        let (f0, eta) = (self.f0.get(i), self.eta[i]);
        move |cos| f0 + (Vec3::ONE - f0) * between(cos, eta)
    }
}

impl Lobe for Specular {
    const IS_DIFFUSE: bool = false;

    #[inline(always)]
    fn is_sharp(&self, i: usize) -> bool {
        self.facets.is_sharp(i)
    }

    fn share(&self) -> &Share {
        &self.facets.share
    }

    fn share_mut(&mut self) -> &mut Share {
        &mut self.facets.share
    }

    #[inline(always)]
    fn evaluate(&self, i: usize, at: &At, toward: Vec3) -> Scattered {
        self.facets.evaluate(i, at, toward, self.fresnel(i))
    }

    #[inline(always)]
    fn sample(&self, i: usize, at: &At, u: [f32; 3]) -> Sampled {
        self.facets.sample(i, at, u, self.fresnel(i))
    }
}
