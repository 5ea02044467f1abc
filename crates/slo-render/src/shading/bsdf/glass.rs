//! Reflection and refraction at the surface of a transparent body, and at a pane.

use glam::Vec3;
use slo_accel::math::columns::{BATCH, Column, Vec3s};

use super::fresnel::{between, cos_refracted};
use super::ggx::{Frame, Seen};
use super::lobe::{At, Lobe, SHARP, Sampled, Scattered, Share};
use crate::shading::lobe::reflect;

/// Microfacets that reflect and refract. Radiance is divided by the square of the relative index
/// of refraction where it passes.
///
/// Source: B. Walter et al., "Microfacet Models for Refraction through Rough Surfaces" (2007).
#[derive(Debug)]
pub struct Glass {
    /// Weights include what light that is scattered several times adds.
    pub(super) share: Share,
    /// Unit normals whose mirror directions lie above the surface.
    pub(super) normal: Vec3s,
    /// Widths; 0 for perfect lobes.
    pub(super) alpha: Column<f32>,
    /// Indices of refraction beyond the surface, divided by those on the side of the eye.
    pub(super) eta: Column<f32>,
    /// Shares of light that are reflected along the normal.
    pub(super) f0: Vec3s,
    /// Multiplies light that passes the surface once.
    pub(super) tint: Vec3s,
    /// 1 for a pane: both its surfaces are one, and light passes unbent. 0 otherwise.
    pub(super) thin: Column<f32>,
}

impl Default for Glass {
    fn default() -> Self {
        Self {
            share: Share::default(),
            normal: Vec3s::default(),
            alpha: [0.0; BATCH],
            eta: [1.0; BATCH],
            f0: Vec3s::default(),
            tint: Vec3s::default(),
            thin: [0.0; BATCH],
        }
    }
}

/// Refraction so weak that its lobe is too narrow for the digits of f32 is perfect.
const LEAST_BEND: f32 = 5e-5;

/// Whether microfacets of width `alpha` make no lobe, but one direction.
#[inline(always)]
pub(super) fn is_perfect(alpha: f32, eta: f32, is_thin: bool) -> bool {
    (alpha == 0.0) | ((alpha * (eta - 1.0).abs() < LEAST_BEND) & !is_thin)
}

/// What a hit does, and what is known of its microfacets.
struct Border {
    frame: Frame,
    seen: Seen,
    is_perfect: bool,
    is_thin: bool,
    eta: f32,
    f0: Vec3,
    tint: Vec3,
}

/// What a microfacet does to light.
struct Parts {
    reflected: Vec3,
    passed: Vec3,
    /// The chance that a sample is reflected.
    chance: f32,
}

impl Border {
    /// What a microfacet does at cosine `cos` of the eye to its normal.
    #[inline(always)]
    fn parts(&self, cos: f32) -> Parts {
        let once = self.f0 + (Vec3::ONE - self.f0) * between(cos, self.eta);
        // Between the surfaces of a pane, light is reflected any number of times.
        let left = (Vec3::ONE - once) / (Vec3::ONE + once);
        let square = self.tint * self.tint;
        let pane = [once * (Vec3::ONE + square * left), square * left];
        let [reflected, passed] =
            if self.is_thin { pane } else { [once, (Vec3::ONE - once) * self.tint] };
        let sum = |v: Vec3| v.x + v.y + v.z;
        let (r, t) = (sum(reflected).sqrt(), sum(passed).sqrt());
        Parts { reflected, passed, chance: r / (r + t).max(f32::MIN_POSITIVE) }
    }

    /// The radiance of light that passes, in the medium of the eye, for a radiance of 1 beyond.
    #[inline(always)]
    fn compression(&self) -> f32 {
        compression(self.eta, self.is_thin)
    }
}

#[inline(always)]
fn compression(eta: f32, is_thin: bool) -> f32 {
    if is_thin { 1.0 } else { 1.0 / (eta * eta) }
}

impl Glass {
    #[inline(always)]
    fn border(&self, i: usize, at: &At) -> Border {
        let frame = Frame::about(self.normal.get(i));
        let (alpha, eta, is_thin) = (self.alpha[i], self.eta[i], self.thin[i] != 0.0);
        let is_perfect = is_perfect(alpha, eta, is_thin);
        // The numbers of a perfect lobe are not used, but should be finite.
        let alpha = if is_perfect { 1.0 } else { alpha };
        Border {
            frame,
            seen: Seen::new(frame.to_local(at.eye), [alpha; 2]),
            is_perfect,
            is_thin,
            eta,
            f0: self.f0.get(i),
            tint: self.tint.get(i),
        }
    }
}

impl Lobe for Glass {
    const IS_DIFFUSE: bool = false;

    #[inline(always)]
    fn is_sharp(&self, i: usize) -> bool {
        self.alpha[i] < SHARP
    }

    #[inline(always)]
    fn of_photon(&self, i: usize, at: &At, direction: Vec3) -> f32 {
        let passed = 1.0 / compression(self.eta[i], self.thin[i] != 0.0);
        if at.n_geo.dot(direction) < 0.0 { passed } else { 1.0 }
    }

    fn share(&self) -> &Share {
        &self.share
    }

    fn share_mut(&mut self) -> &mut Share {
        &mut self.share
    }

    #[inline(always)]
    fn evaluate(&self, i: usize, at: &At, toward: Vec3) -> Scattered {
        let border = self.border(i, at);
        let Border { frame, seen, is_perfect, is_thin, eta, .. } = border;
        let light = frame.to_local(toward);
        let passes = light.z < 0.0;
        let is_bent = passes & !is_thin;
        // A pane scatters light that passes like light that it reflects, to the other side.
        let mirrored = Vec3::new(light.x, light.y, light.z.abs());
        let sum = seen.eye + if is_bent { light * eta } else { mirrored };
        let h = sum * (1.0 / sum.length().max(f32::MIN_POSITIVE));
        let h = if h.z < 0.0 { -h } else { h };
        let (cos, cos_t) = (seen.eye.dot(h), light.dot(h));
        let parts = border.parts(cos.clamp(0.0, 1.0));
        let [part, chance] = if passes {
            [parts.passed * border.compression(), Vec3::splat(1.0 - parts.chance)]
        } else {
            [parts.reflected, Vec3::splat(parts.chance)]
        };
        let along = cos + eta * cos_t;
        let bent = cos * eta * eta * cos_t.abs() / (along * along).max(f32::MIN_POSITIVE);
        let density = seen.density(h) * if is_bent { bent } else { 0.25 };
        let is_there = !is_bent | ((cos > 0.0) & (cos_t < 0.0));
        let is_same_side = (at.n_geo.dot(toward) < 0.0) == passes;
        let density = if is_there & is_same_side & !is_perfect { density } else { 0.0 };
        let part = part * (seen.passed(light, light.z.abs()) * density);
        Scattered { value: self.share.weight.get(i) * part, density: density * chance.x }
    }

    #[inline(always)]
    fn sample(&self, i: usize, at: &At, u: [f32; 3]) -> Sampled {
        let border = self.border(i, at);
        let Border { frame, seen, is_perfect, is_thin, eta, .. } = border;
        let h = if is_perfect { Vec3::Z } else { seen.sample([u[0], u[1]]) };
        let cos = seen.eye.dot(h).clamp(0.0, 1.0);
        let cos_t = cos_refracted(cos, eta);
        let parts = border.parts(cos);
        let passes = u[2] >= parts.chance;
        let is_bent = passes & !is_thin;
        let reflected = reflect(-seen.eye, h);
        let unbent = if is_perfect { -seen.eye } else { reflected * Vec3::new(1.0, 1.0, -1.0) };
        let refracted = (h * (cos - eta * cos_t) - seen.eye) / eta;
        let through = if is_thin { unbent } else { refracted };
        let light = if passes { through } else { reflected };
        let direction = frame.to_world(light);
        let direction = direction * (1.0 / direction.length().max(f32::MIN_POSITIVE));
        let [part, chance] = if passes {
            [parts.passed * border.compression(), Vec3::splat(1.0 - parts.chance)]
        } else {
            [parts.reflected, Vec3::splat(parts.chance)]
        };
        let side = if passes { -1.0 } else { 1.0 };
        let is_there = (light.z * side > 0.0) & (at.n_geo.dot(direction) * side > 0.0);
        let left = if is_perfect { 1.0 } else { seen.passed(light, light.z.abs()) };
        let part = part * (left / chance.x.max(f32::MIN_POSITIVE));
        let along = cos - eta * cos_t;
        let bent = cos * eta * eta * cos_t / (along * along).max(f32::MIN_POSITIVE);
        let density = seen.density(h) * if is_bent { bent } else { 0.25 } * chance.x;
        Sampled {
            direction,
            weight: if is_there { self.share.weight.get(i) * part } else { Vec3::ZERO },
            density: if is_perfect { 0.0 } else { density },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pane_reflects_as_two_surfaces() {
        let glass = Glass {
            f0: {
                let mut f0 = Vec3s::default();
                f0.set(0, Vec3::splat(0.04));
                f0
            },
            tint: {
                let mut tint = Vec3s::default();
                tint.set(0, Vec3::ONE);
                tint
            },
            eta: [1.5; BATCH],
            thin: [1.0; BATCH],
            normal: {
                let mut normal = Vec3s::default();
                normal.set(0, Vec3::Z);
                normal
            },
            ..Glass::default()
        };
        let at = At {
            eye: Vec3::Z,
            n: Vec3::Z,
            n_geo: Vec3::Z,
            floor: Vec3::Z,
            is_bent: false,
            tangent: Vec3::ZERO,
        };
        let parts = glass.border(0, &at).parts(1.0);
        assert!((parts.reflected - 0.076_923).abs().max_element() < 1e-5, "{}", parts.reflected);
        assert!((parts.passed - 0.923_077).abs().max_element() < 1e-5, "{}", parts.passed);
    }
}
