//! The reflection of a dielectric over a diffuse base.

use glam::Vec3;
use slo_accel::math::columns::{BATCH, Column, Vec3s};

use super::facets::{Faceted, Facets};
use super::fresnel::between;

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

impl Faceted for Specular {
    #[inline(always)]
    fn facets(&self) -> &Facets {
        &self.facets
    }

    fn facets_mut(&mut self) -> &mut Facets {
        &mut self.facets
    }

    #[inline(always)]
    fn fresnel(&self, i: usize) -> impl Fn(f32) -> Vec3 {
        let (f0, eta) = (self.f0.get(i), self.eta[i]);
        move |cos| f0 + (Vec3::ONE - f0) * between(cos, eta)
    }
}
