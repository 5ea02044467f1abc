//! What all lobes that microfacets reflect have in common.

use glam::Vec3;
use slo_accel::math::columns::{BATCH, Column, Vec3s};

use super::ggx::{Frame, Seen};
use super::lobe::{At, Lobe, SHARP, Sampled, Scattered, Share};
use crate::shading::lobe::reflect;

/// Microfacets of the hits of a batch.
#[derive(Debug)]
pub struct Facets {
    /// Weights include what light that is reflected several times adds.
    pub(super) share: Share,
    /// Unit normals whose mirror directions lie above the surface.
    pub(super) normal: Vec3s,
    /// Unit tangents.
    pub(super) x: Vec3s,
    /// Widths along and across the tangent; 0 for perfect lobes.
    pub(super) alpha: [Column<f32>; 2],
}

impl Default for Facets {
    fn default() -> Self {
        Self {
            share: Share::default(),
            normal: Vec3s::default(),
            x: Vec3s::default(),
            alpha: [[0.0; BATCH]; 2],
        }
    }
}

/// A lobe of light that microfacets reflect.
pub trait Faceted {
    fn facets(&self) -> &Facets;

    fn facets_mut(&mut self) -> &mut Facets;

    /// Returns the share of light that a microfacet of hit `i` reflects, by the cosine to its normal.
    fn fresnel(&self, i: usize) -> impl Fn(f32) -> Vec3;
}

impl<T: Faceted> Lobe for T {
    const IS_DIFFUSE: bool = false;

    #[inline(always)]
    fn is_sharp(&self, i: usize) -> bool {
        self.facets().is_sharp(i)
    }

    fn share(&self) -> &Share {
        &self.facets().share
    }

    fn share_mut(&mut self) -> &mut Share {
        &mut self.facets_mut().share
    }

    #[inline(always)]
    fn evaluate(&self, i: usize, at: &At, toward: Vec3) -> Scattered {
        self.facets().evaluate(i, at, toward, self.fresnel(i))
    }

    #[inline(always)]
    fn sample(&self, i: usize, at: &At, u: [f32; 3]) -> Sampled {
        self.facets().sample(i, at, u, self.fresnel(i))
    }
}

impl Facets {
    /// The frame of hit `i`, its view from the eye, and whether the lobe is perfect.
    #[inline(always)]
    fn seen(&self, i: usize, at: &At) -> (Frame, Seen, bool) {
        let frame = Frame::of(self.x.get(i), self.normal.get(i));
        let alpha = [self.alpha[0][i], self.alpha[1][i]];
        let is_perfect = alpha[0] == 0.0;
        // The numbers of a perfect lobe are not used, but should be finite.
        let alpha = if is_perfect { [1.0; 2] } else { alpha };
        (frame, Seen::new(frame.to_local(at.eye), alpha), is_perfect)
    }

    /// See [`Lobe::is_sharp`].
    #[inline(always)]
    fn is_sharp(&self, i: usize) -> bool {
        self.alpha[0][i].max(self.alpha[1][i]) < SHARP
    }

    /// See [`Lobe::evaluate`] and [`Faceted::fresnel`].
    #[inline(always)]
    fn evaluate(
        &self,
        i: usize,
        at: &At,
        toward: Vec3,
        fresnel: impl Fn(f32) -> Vec3,
    ) -> Scattered {
        let (frame, seen, is_perfect) = self.seen(i, at);
        let light = frame.to_local(toward);
        let sum = seen.eye + light;
        let h = sum * (1.0 / sum.length().max(f32::MIN_POSITIVE));
        let density = 0.25 * seen.density(h);
        let is_lit = (light.z > 0.0) & (at.floor.dot(toward) > 0.0) & !is_perfect;
        let density = if is_lit { density } else { 0.0 };
        let reflected = fresnel(seen.eye.dot(h).clamp(0.0, 1.0)) * seen.passed(light, light.z);
        Scattered { value: self.share.weight.get(i) * reflected * density, density }
    }

    /// See [`Lobe::sample`] and [`evaluate`](Self::evaluate).
    #[inline(always)]
    pub(super) fn sample(
        &self,
        i: usize,
        at: &At,
        u: [f32; 3],
        fresnel: impl Fn(f32) -> Vec3,
    ) -> Sampled {
        let (frame, seen, is_perfect) = self.seen(i, at);
        let h = seen.sample([u[0], u[1]]);
        let h = if is_perfect { Vec3::Z } else { h };
        let light = reflect(-seen.eye, h);
        let direction = frame.to_world(light);
        let direction = direction * (1.0 / direction.length().max(f32::MIN_POSITIVE));
        let is_lit = (light.z > 0.0) & (at.floor.dot(direction) > 0.0);
        let passed = if is_perfect { 1.0 } else { seen.passed(light, light.z) };
        let reflected = fresnel(seen.eye.dot(h).clamp(0.0, 1.0)) * passed;
        let weight = self.share.weight.get(i) * reflected;
        Sampled {
            direction,
            weight: if is_lit { weight } else { Vec3::ZERO },
            density: if is_perfect { 0.0 } else { 0.25 * seen.density(h) },
        }
    }
}
