//! The reflection of metals.

use glam::Vec3;
use slo_accel::math::columns::Vec3s;

use super::facets::{Faceted, Facets};
use super::fresnel;

/// Microfacets of metal, by the F82 tint model.
#[derive(Debug, Default)]
pub struct Metal {
    pub(super) facets: Facets,
    /// Shares of light that are reflected along the normal.
    pub(super) f0: Vec3s,
    /// See [`fresnel::Metal::bend`].
    pub(super) bend: Vec3s,
}

impl Faceted for Metal {
    #[inline(always)]
    fn facets(&self) -> &Facets {
        &self.facets
    }

    fn facets_mut(&mut self) -> &mut Facets {
        &mut self.facets
    }

    #[inline(always)]
    fn fresnel(&self, i: usize) -> impl Fn(f32) -> Vec3 {
        let metal = fresnel::Metal { f0: self.f0.get(i), bend: self.bend.get(i) };
        move |cos| metal.at(cos)
    }
}
