//! The reflection of metals.

use glam::Vec3;
use slo_accel::math::columns::Vec3s;

use super::facets::Facets;
use super::fresnel;
use super::lobe::{At, Lobe, Sampled, Scattered, Share};

/// Microfacets of metal, by the F82 tint model.
#[derive(Debug, Default)]
pub struct Metal {
    pub(super) facets: Facets,
    /// Shares of light that are reflected along the normal.
    pub(super) f0: Vec3s,
    /// See [`fresnel::Metal::bend`].
    pub(super) bend: Vec3s,
}

impl Metal {
    #[inline(always)]
    fn fresnel(&self, i: usize) -> impl Fn(f32) -> Vec3 {
        let metal = fresnel::Metal { f0: self.f0.get(i), bend: self.bend.get(i) };
        move |cos| metal.at(cos)
    }
}

impl Lobe for Metal {
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
