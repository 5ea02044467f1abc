//! The reflection of a clear coat over everything else.

use glam::Vec3;
use slo_accel::math::columns::{BATCH, Column};

use super::facets::{Faceted, Facets};
use super::fresnel::dielectric;

/// Microfacets of a dielectric.
#[derive(Debug)]
pub struct Coat {
    pub(super) facets: Facets,
    /// Indices of refraction.
    pub(super) eta: Column<f32>,
}

impl Default for Coat {
    fn default() -> Self {
        Self { facets: Facets::default(), eta: [1.0; BATCH] }
    }
}

impl Faceted for Coat {
    #[inline(always)]
    fn facets(&self) -> &Facets {
        &self.facets
    }

    fn facets_mut(&mut self) -> &mut Facets {
        &mut self.facets
    }

    #[inline(always)]
    fn fresnel(&self, i: usize) -> impl Fn(f32) -> Vec3 {
        let eta = self.eta[i];
        move |cos| Vec3::splat(dielectric(cos, eta))
    }
}
