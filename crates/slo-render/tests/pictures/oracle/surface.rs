//! What surfaces of `material_principled` do to light: Lambert's base, metal, and smooth glass.

use std::f64::consts::{FRAC_1_PI, TAU};

use glam::DVec3;

use slo_render::shading::bsdf::facet_albedos;
use slo_scene::material::Principled;

use super::lamps::color;
use super::points::lobe;

/// A lobe of a hit, and the chance that a ray follows it.
pub(super) struct Lobe {
    /// Includes what the layers above let through.
    weight: DVec3,
    pub(super) chance: f64,
    kind: Kind,
}

enum Kind {
    Diffuse,
    /// GGX; perfect if `alpha` is 0. `fresnel` is the reflection along the normal.
    Metal {
        alpha: f64,
        fresnel: Metal,
    },
    /// `eta` is the index of refraction beyond the surface over that on the side of the eye.
    Glass {
        eta: f64,
        tint: DVec3,
    },
}

/// The directions of a hit: unit vectors. Surfaces are flat, so there is one normal, on the side of
/// the eye.
#[derive(Clone, Copy)]
pub(super) struct Facing {
    pub(super) eye: DVec3,
    pub(super) n: DVec3,
    pub(super) from_outside: bool,
}

/// A direction that a lobe samples.
pub(super) struct Sampled {
    pub(super) direction: DVec3,
    /// BSDF times cosine over the density.
    pub(super) weight: DVec3,
    /// 0 for a perfect lobe.
    pub(super) density: f64,
}

/// Returns the lobes of a hit, in the order in which a random number chooses among them.
pub(super) fn lobes(of: &Principled, facing: Facing) -> Vec<Lobe> {
    let cos = facing.eye.dot(facing.n);
    let base = color(of.base_color.value);
    let roughness = of.roughness.value;
    let [metallic, transmission] = [&of.metallic, &of.transmission].map(|v| f64::from(v.value));
    let known = of.coat.value == 0.0 && of.sheen.value == 0.0 && of.diffuse_roughness.value == 0.0;
    assert!(known && !of.thin && of.anisotropic.value == 0.0, "the oracle does not know {of:?}");
    let left = (1.0 - metallic) * (1.0 - transmission);
    assert!(left == 0.0 || of.specular_ior_level.value == 0.0, "the oracle knows no gloss");
    assert!(transmission == 0.0 || roughness == 0.0, "the oracle knows no rough glass");
    let alpha = f64::from(roughness * roughness);
    let metal = Metal::new(base, color(of.specular_tint.value));
    let [single, mean] = facet_albedos(roughness, cos as f32).map(f64::from);
    // What is scattered several times: Turquin (2019).
    let average = metal.mean();
    let several = average * mean / (1.0 - average * (1.0 - mean));
    let boost = 1.0 + several * ((1.0 - single) / single);
    let ior = f64::from(of.ior.value);
    let eta = if facing.from_outside { ior } else { 1.0 / ior };
    let tint = DVec3::new(base.x.sqrt(), base.y.sqrt(), base.z.sqrt());
    let reflected = DVec3::splat(dielectric(cos, eta));
    let passing = reflected + (1.0 - reflected) * tint;
    let weights = [
        (Kind::Diffuse, base * left, DVec3::ONE),
        (Kind::Metal { alpha, fresnel: metal }, boost * metallic, metal.at(cos) * single),
        (Kind::Glass { eta, tint }, DVec3::splat((1.0 - metallic) * transmission), passing),
    ];
    let lobes = weights.into_iter().map(|(kind, weight, albedo)| {
        let chance = (weight * albedo.max(DVec3::splat(1e-3))).element_sum() / 3.0;
        Lobe { weight, chance, kind }
    });
    let mut lobes: Vec<Lobe> = lobes.collect();
    let total: f64 = lobes.iter().map(|lobe| lobe.chance).sum();
    lobes.retain(|lobe| lobe.chance > 0.0);
    lobes.iter_mut().for_each(|lobe| lobe.chance /= total);
    lobes
}

impl Lobe {
    /// Returns BSDF times cosine for light from a direction, and the density with which the lobe
    /// samples it.
    pub(super) fn evaluate(&self, facing: Facing, toward: DVec3) -> (DVec3, f64) {
        let cos = facing.n.dot(toward);
        let nothing = (DVec3::ZERO, 0.0);
        match self.kind {
            Kind::Diffuse if cos > 0.0 => (self.weight * cos * FRAC_1_PI, cos * FRAC_1_PI),
            Kind::Metal { alpha, fresnel } if cos > 0.0 && alpha > 0.0 => {
                let h = (facing.eye + toward).normalize();
                let density = density_of_normals(facing, h, alpha) / (4.0 * facing.eye.dot(h));
                let reflected = fresnel.at(facing.eye.dot(h)) * passed(facing, toward, alpha);
                (self.weight * reflected * density, density)
            }
            _ => nothing,
        }
    }

    /// Samples a direction of incident light.
    pub(super) fn sample(&self, facing: Facing, u: [f64; 3]) -> Sampled {
        let Facing { eye, n, .. } = facing;
        match self.kind {
            Kind::Diffuse => {
                // A spread of 1 is the lobe of the cosine.
                let direction = lobe(n, 1.0, [u[0], u[1]]);
                Sampled { direction, weight: self.weight, density: n.dot(direction) * FRAC_1_PI }
            }
            Kind::Metal { alpha, fresnel } => {
                let h = if alpha > 0.0 { visible_normal(facing, alpha, [u[0], u[1]]) } else { n };
                let direction = 2.0 * eye.dot(h) * h - eye;
                if n.dot(direction) <= 0.0 {
                    return Sampled { direction, weight: DVec3::ZERO, density: 0.0 };
                }
                let reflected = self.weight * fresnel.at(eye.dot(h));
                if alpha == 0.0 {
                    return Sampled { direction, weight: reflected, density: 0.0 };
                }
                let density = density_of_normals(facing, h, alpha) / (4.0 * eye.dot(h));
                Sampled { direction, weight: reflected * passed(facing, direction, alpha), density }
            }
            Kind::Glass { eta, tint } => {
                let cos = eye.dot(n);
                let reflected = DVec3::splat(dielectric(cos, eta));
                let passing = (1.0 - reflected) * tint;
                let [r, t] = [reflected, passing].map(DVec3::element_sum);
                // Weak reflections are followed more often than their share.
                let (r, t) = (r.sqrt(), t.sqrt());
                let chance = r / (r + t);
                if u[2] < chance {
                    let (direction, weight) = (2.0 * cos * n - eye, reflected / chance);
                    return Sampled { direction, weight: self.weight * weight, density: 0.0 };
                }
                let cos_t = (1.0 - (1.0 - cos * cos) / (eta * eta)).max(0.0).sqrt();
                let direction = (n * (cos - eta * cos_t) - eye) / eta;
                let weight = passing / ((1.0 - chance) * eta * eta);
                Sampled { direction, weight: self.weight * weight, density: 0.0 }
            }
        }
    }
}

/// Smith's Lambda of GGX, for a direction at a cosine.
fn lambda(cos: f64, alpha: f64) -> f64 {
    let tan2 = (1.0 - cos * cos).max(0.0) / (cos * cos);
    (-1.0 + (1.0 + alpha * alpha * tan2).sqrt()) / 2.0
}

/// The density of the normals that the eye sees: D G1 (eye . h) / cos.
fn density_of_normals(facing: Facing, h: DVec3, alpha: f64) -> f64 {
    let (cos, cos_h) = (facing.eye.dot(facing.n), h.dot(facing.n));
    let t = cos_h * cos_h * (alpha * alpha - 1.0) + 1.0;
    let d = alpha * alpha * FRAC_1_PI / (t * t);
    d * facing.eye.dot(h) / (cos * (1.0 + lambda(cos, alpha)))
}

/// G2 / G1, correlated by height: the share of the visible microfacets that the light sees too.
fn passed(facing: Facing, toward: DVec3, alpha: f64) -> f64 {
    let [eye, light] = [facing.eye, toward].map(|w| lambda(w.dot(facing.n), alpha));
    (1.0 + eye) / (1.0 + eye + light)
}

/// Samples a normal of the visible microfacets: Dupuy and Benyoub (2023), about the frame of Duff.
fn visible_normal(facing: Facing, alpha: f64, u: [f64; 2]) -> DVec3 {
    let Facing { eye, n, .. } = facing;
    let (x, y) = n.any_orthonormal_pair();
    let stretched = DVec3::new(eye.dot(x) * alpha, eye.dot(y) * alpha, eye.dot(n)).normalize();
    let (s, c) = libm::sincos(u[0] * TAU);
    let z = 1.0 - u[1] * (1.0 + stretched.z);
    let sine = (1.0 - z * z).max(0.0).sqrt();
    let h = DVec3::new(sine * c, sine * s, z) + stretched;
    (x * (h.x * alpha) + y * (h.y * alpha) + n * h.z).normalize()
}

/// The share of light that the border of two dielectrics reflects: Fresnel's formulas.
fn dielectric(cos: f64, eta: f64) -> f64 {
    let square = 1.0 - (1.0 - cos * cos) / (eta * eta);
    if square <= 0.0 {
        return 1.0;
    }
    let cos_t = square.sqrt();
    let s = (cos - eta * cos_t) / (cos + eta * cos_t);
    let p = (eta * cos - cos_t) / (eta * cos + cos_t);
    0.5 * (s * s + p * p)
}

/// The reflection of a metal: Schlick's curve, multiplied by a tint at a cosine of 1/7.
#[derive(Clone, Copy)]
struct Metal {
    f0: DVec3,
    bend: DVec3,
}

impl Metal {
    fn new(f0: DVec3, tint: DVec3) -> Self {
        let cos = 1.0 / 7.0f64;
        let there = f0 + (1.0 - f0) * libm::pow(1.0 - cos, 5.0);
        Self { f0, bend: there * (1.0 - tint) / (cos * libm::pow(1.0 - cos, 6.0)) }
    }

    fn at(self, cos: f64) -> DVec3 {
        let left = 1.0 - cos;
        let bent = self.f0 + (1.0 - self.f0) * libm::pow(left, 5.0)
            - self.bend * cos * libm::pow(left, 6.0);
        bent.clamp(DVec3::ZERO, DVec3::ONE)
    }

    /// The mean over all directions, weighted by the cosine.
    fn mean(self) -> DVec3 {
        (self.f0 + (1.0 - self.f0) / 21.0 - self.bend / 126.0).clamp(DVec3::ZERO, DVec3::ONE)
    }
}
