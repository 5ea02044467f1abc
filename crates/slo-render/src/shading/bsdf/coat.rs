//! The reflection of a clear coat over everything else.

use glam::Vec3;
use slo_accel::math::columns::{BATCH, Column};

use super::facets::Facets;
use super::fresnel::dielectric;
use super::lobe::{At, Lobe, Sampled, Scattered, Share};

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

impl Coat {
    #[inline(always)]
    fn fresnel(&self, i: usize) -> impl Fn(f32) -> Vec3 {
        let eta = self.eta[i];
        move |cos| Vec3::splat(dielectric(cos, eta))
    }
}

impl Lobe for Coat {
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
