//! The lobes of `material_principled`, in layers.
//!
//! From the top down: sheen; coat; metal, mixed with glass, mixed with a diffuse base under gloss.
//! What lies under a layer gets what the layer's directional albedo toward the eye leaves, as in
//! Blender: the sum of all is not reciprocal. All layers look the same from inside a body, but for
//! glass, which is seen from within.

use std::array;

use glam::Vec3;
use slo_accel::math::columns::{BATCH, Column, Vec3s, lanes};
use slo_accel::math::elementary::{power, sin_cos_turns};
use slo_accel::{Isa, Lanewise};

use super::bend::bent;
use super::facets::Facets;
use super::fresnel::{self, between, cos_refracted, index_of, normal_incidence};
use super::ggx::{LEAST_ROUGHNESS, widths};
use super::glass::is_perfect;
use super::lobe::{At, Lobe, Share};
use super::tables::{INSIDE, TABLES, Tables};
use super::{Bsdf, Coat, Diffuse, Glass, Metal, RoughDiffuse, Sheen, Specular};
use crate::shading::lobe::pair;
use crate::shading::material::principled::Parameters;

/// Sets all lobes of hits that have a principled material: those for which `is_mine`. `from_outside`
/// is 0 where the eye is inside a body. Hits with other materials keep lobes that the kinds share,
/// and have none of the others. `emitted` becomes the share of emitted light that coat and sheen
/// let through.
#[expect(clippy::too_many_arguments, reason = "columns of one batch")]
pub fn principled(
    parameters: &Parameters,
    at: impl Fn(usize) -> At,
    from_outside: &Column<u32>,
    is_mine: impl Fn(usize) -> bool,
    len: usize,
    isa: Isa,
    to: &mut Bsdf,
    emitted: &mut Vec3s,
) {
    let tables = &*TABLES;
    isa.run(Set { parameters, at, from_outside, is_mine, len, tables, to, emitted });
}

struct Set<'a, A, M> {
    parameters: &'a Parameters,
    at: A,
    from_outside: &'a Column<u32>,
    is_mine: M,
    len: usize,
    tables: &'a Tables,
    to: &'a mut Bsdf,
    emitted: &'a mut Vec3s,
}

impl<A: Fn(usize) -> At, M: Fn(usize) -> bool> Lanewise for Set<'_, A, M> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { parameters, at, from_outside, is_mine, len, tables, to, emitted } = self;
        let mut views = Views::default();
        look(parameters, &at, &is_mine, len, &mut views);
        let glass_eta = &mut to.glass.eta;
        indices(parameters, from_outside, len, &mut to.specular.eta, &mut to.coat.eta, glass_eta);
        let mut found = Found::default();
        found.look_up(tables, parameters, &views, to, len);
        let left = &mut views.left;
        *emitted = Vec3s::default();
        sheen(parameters, &views.cos_shading, len, left, &mut to.sheen);
        coat(parameters, &views.cos, &found, len, left, &mut to.coat);
        for i in lanes(len) {
            emitted.set(i, left.get(i));
        }
        metal(parameters, &found, &views.cos, len, left, &mut to.metal);
        glass(parameters, &found, &views.cos, len, left, &mut to.glass);
        specular(parameters, &found, &views.cos, len, left, &mut to.specular);
        diffuse(parameters, &views, &is_mine, len, &mut to.diffuse, &mut to.rough_diffuse);
        place(parameters, &views, len, to);
        for share in [
            to.sheen.share_mut(),
            to.coat.share_mut(),
            to.metal.share_mut(),
            to.glass.share_mut(),
            to.specular.share_mut(),
            to.rough_diffuse.share_mut(),
            to.diffuse.share_mut(),
        ] {
            share.is_present = is_any(share, len);
        }
    }
}

/// How hits are seen.
#[derive(Default)]
struct Views {
    /// See [`bent`].
    normal: Vec3s,
    /// Tangents of [`normal`](Self::normal), turned as the material says.
    x: Vec3s,
    /// Cosine of the eye to [`normal`](Self::normal).
    cos: Numbers,
    /// Cosine of the eye to the shading normal; 0 if it is negative.
    cos_shading: Numbers,
    /// The share of light that the layers so far leave.
    left: Vec3s,
}

/// A column with a default.
struct Numbers(Column<f32>);

impl Default for Numbers {
    fn default() -> Self {
        Self([0.0; BATCH])
    }
}

#[inline(always)]
fn look(
    parameters: &Parameters,
    at: &impl Fn(usize) -> At,
    is_mine: &impl Fn(usize) -> bool,
    len: usize,
    to: &mut Views,
) {
    for i in lanes(len) {
        let At { eye, n, n_geo, tangent, .. } = at(i);
        let normal = bent(eye, n, n_geo);
        let along = tangent - normal * tangent.dot(normal);
        let length = along.length();
        let is_given = length > 1e-6 * tangent.length();
        let along = if is_given { along / length.max(1e-30) } else { pair(normal).0 };
        let (s, c) = sin_cos_turns(parameters.anisotropic_rotation[i].clamp(-1e4, 1e4));
        to.x.set(i, along * c + normal.cross(along) * s);
        to.normal.set(i, normal);
        to.cos.0[i] = normal.dot(eye).clamp(0.0, 1.0);
        to.cos_shading.0[i] = n.dot(eye).clamp(0.0, 1.0);
        to.left.set(i, if is_mine(i) { Vec3::ONE } else { Vec3::ZERO });
    }
}

/// Computes the relative indices of refraction of all layers.
#[inline(always)]
fn indices(
    parameters: &Parameters,
    from_outside: &Column<u32>,
    len: usize,
    specular: &mut Column<f32>,
    coat: &mut Column<f32>,
    glass: &mut Column<f32>,
) {
    for i in lanes(len) {
        let ior = parameters.ior[i].clamp(0.01, 100.0);
        let is_inside = (from_outside[i] == 0) & (parameters.thin[i] == 0.0);
        glass[i] = if is_inside { 1.0 / ior } else { ior };
        coat[i] = parameters.coat_ior[i].clamp(1.0, 100.0);
        let level = parameters.specular_ior_level[i];
        let levelled = index_of(normal_incidence(ior) * 2.0 * level);
        let levelled = if level == 0.5 { ior.max(1.0 / ior) } else { levelled };
        specular[i] = if ior < 1.0 { 1.0 / levelled } else { levelled };
    }
}

/// What the tables say of hits.
#[derive(Default)]
struct Found {
    /// See [`Tables::single`] and [`Tables::mean`].
    base: [Numbers; 2],
    coat: [Numbers; 2],
    /// See [`Tables::curve`] and [`Tables::curve_mean`].
    base_curve: [Numbers; 2],
    coat_curve: [Numbers; 2],
    /// Of glass, see [`Body::single`](super::tables::Body::single), and its mean.
    glass: [Numbers; 2],
    /// See [`Tables::curve_mean`].
    glass_curve: Numbers,
}

impl Found {
    #[inline(always)]
    fn look_up(
        &mut self,
        tables: &Tables,
        parameters: &Parameters,
        views: &Views,
        bsdf: &Bsdf,
        len: usize,
    ) {
        let cos = &views.cos.0;
        single(tables, &parameters.roughness, cos, len, &mut self.base);
        single(tables, &parameters.coat_roughness, cos, len, &mut self.coat);
        let (specular, coat) = (&bsdf.specular.eta, &bsdf.coat.eta);
        curve(tables, specular, &parameters.roughness, cos, len, &mut self.base_curve);
        curve(tables, coat, &parameters.coat_roughness, cos, len, &mut self.coat_curve);
        let eta = &bsdf.glass.eta;
        let mut any_inside = false;
        for i in lanes(len) {
            let is_inside = (eta[i] < 1.0) & (parameters.transmission[i] > 0.0);
            any_inside |= is_inside & (parameters.roughness[i] >= LEAST_ROUGHNESS) & (i < len);
            let body = tables.outside();
            let is_thin = parameters.thin[i] != 0.0;
            let single = body.single(eta[i], parameters.roughness[i], cos[i]);
            let mean = body.mean(eta[i], parameters.roughness[i]);
            self.glass_curve.0[i] = tables.curve_mean(eta[i]);
            self.glass[0].0[i] = if is_thin { self.base[0].0[i] } else { single };
            self.glass[1].0[i] = if is_thin { self.base[1].0[i] } else { mean };
        }
        if any_inside {
            let inside = &*INSIDE;
            for i in lanes(len) {
                let is_inside = (eta[i] < 1.0) & (parameters.thin[i] == 0.0);
                let single = inside.single(eta[i], parameters.roughness[i], cos[i]);
                let mean = inside.mean(eta[i], parameters.roughness[i]);
                let [before, mean_before] = at_hit(&self.glass, i);
                self.glass[0].0[i] = if is_inside { single } else { before };
                self.glass[1].0[i] = if is_inside { mean } else { mean_before };
            }
        }
        for i in lanes(len) {
            let alpha = widths(parameters.roughness[i], 0.0)[0];
            let is_perfect = is_perfect(alpha, eta[i], parameters.thin[i] != 0.0);
            let found = self.glass[0].0[i].max(0.01);
            self.glass[0].0[i] = if is_perfect { 1.0 } else { found };
        }
    }
}

#[inline(always)]
fn single(
    tables: &Tables,
    roughness: &Column<f32>,
    cos: &Column<f32>,
    len: usize,
    [single, mean]: &mut [Numbers; 2],
) {
    for i in lanes(len) {
        let is_perfect = roughness[i] < LEAST_ROUGHNESS;
        let found = tables.single(roughness[i], cos[i]).max(0.01);
        single.0[i] = if is_perfect { 1.0 } else { found };
        mean.0[i] = tables.mean(roughness[i]);
    }
}

#[inline(always)]
fn curve(
    tables: &Tables,
    eta: &Column<f32>,
    roughness: &Column<f32>,
    cos: &Column<f32>,
    len: usize,
    [curve, mean]: &mut [Numbers; 2],
) {
    for i in lanes(len) {
        let perfect = between(cos[i], eta[i]);
        let found = tables.curve(eta[i], roughness[i], cos[i]);
        let is_perfect = (roughness[i] < LEAST_ROUGHNESS) | (eta[i] < 1.0);
        curve.0[i] = if is_perfect { perfect } else { found };
        mean.0[i] = tables.curve_mean(eta[i]);
    }
}

/// The factor of single scattering that accounts for light that is scattered several times: `fresnel`
/// is the mean share of light that a microfacet reflects.
///
/// Source: E. Turquin, "Practical multiple scattering compensation for microfacet models" (2019).
#[inline(always)]
fn boost(fresnel: Vec3, [single, mean]: [f32; 2]) -> Vec3 {
    let several = fresnel * mean / (Vec3::ONE - fresnel * (1.0 - mean));
    several * ((1.0 - single) / single) + 1.0
}

#[inline(always)]
fn at_hit<const N: usize>(of: &[Numbers; N], i: usize) -> [f32; N] {
    array::from_fn(
        #[inline(always)]
        |k| of[k].0[i],
    )
}

/// Sets a weight and its chance, for a lobe of albedo `albedo` without its weight.
#[inline(always)]
fn set(share: &mut Share, i: usize, weight: Vec3, albedo: Vec3) {
    share.weight.set(i, weight);
    let scattered = weight * albedo.max(Vec3::splat(1e-3));
    share.chance[i] = (scattered.x + scattered.y + scattered.z) * (1.0 / 3.0);
}

#[inline(always)]
fn sheen(parameters: &Parameters, cos: &Numbers, len: usize, left: &mut Vec3s, to: &mut Sheen) {
    for i in lanes(len) {
        let above = left.get(i);
        let albedo = to.set(i, parameters.sheen_roughness[i], cos.0[i]);
        let scattered = parameters.sheen_tint.get(i) * (parameters.sheen[i] * albedo);
        set(&mut to.share, i, above * scattered, Vec3::ONE);
        left.set(i, above * (1.0 - scattered.max_element()).clamp(0.0, 1.0));
    }
}

#[inline(always)]
fn coat(
    parameters: &Parameters,
    cos: &Numbers,
    found: &Found,
    len: usize,
    left: &mut Vec3s,
    to: &mut Coat,
) {
    for i in lanes(len) {
        let above = left.get(i);
        let (amount, eta) = (parameters.coat[i], to.eta[i]);
        let albedos = at_hit(&found.coat, i);
        let [curve, mean] = at_hit(&found.coat_curve, i);
        let f0 = normal_incidence(eta);
        let boost = boost(Vec3::splat(f0 + (1.0 - f0) * mean), albedos);
        let albedo = boost * ((f0 + (1.0 - f0) * curve) * albedos[0]);
        let fresnel = Vec3::splat(f0 + (1.0 - f0) * curve);
        set(&mut to.facets.share, i, above * boost * amount, fresnel * albedos[0]);
        // The tint is that of light along the normal; at other angles it goes a longer way.
        let way = 1.0 / cos_refracted(cos.0[i], eta).max(1e-3);
        let tint = parameters.coat_tint.get(i);
        let tint = Vec3::new(power(tint.x, way), power(tint.y, way), power(tint.z, way));
        let below = above * (1.0 - amount * albedo.max_element()).clamp(0.0, 1.0);
        left.set(i, below * (Vec3::ONE + (tint - Vec3::ONE) * amount));
    }
}

#[inline(always)]
fn metal(
    parameters: &Parameters,
    found: &Found,
    cos: &Numbers,
    len: usize,
    left: &mut Vec3s,
    to: &mut Metal,
) {
    for i in lanes(len) {
        let above = left.get(i);
        let tint = parameters.specular_tint.get(i);
        let metal = fresnel::Metal::new(parameters.base_color.get(i), tint);
        to.f0.set(i, metal.f0);
        to.bend.set(i, metal.bend);
        let amount = parameters.metallic[i];
        let albedos = at_hit(&found.base, i);
        let weight = above * boost(metal.mean(), albedos) * amount;
        set(&mut to.facets.share, i, weight, metal.at(cos.0[i]) * albedos[0]);
        left.set(i, above * (1.0 - amount));
    }
}

#[inline(always)]
fn glass(
    parameters: &Parameters,
    found: &Found,
    cos: &Numbers,
    len: usize,
    left: &mut Vec3s,
    to: &mut Glass,
) {
    for i in lanes(len) {
        let above = left.get(i);
        let color = parameters.base_color.get(i).max(Vec3::ZERO);
        let tint = Vec3::new(color.x.sqrt(), color.y.sqrt(), color.z.sqrt());
        let f0 = parameters.specular_tint.get(i) * normal_incidence(to.eta[i]);
        to.f0.set(i, f0);
        to.tint.set(i, tint);
        to.thin[i] = parameters.thin[i];
        to.alpha[i] = widths(parameters.roughness[i], 0.0)[0];
        let amount = parameters.transmission[i];
        let albedos = at_hit(&found.glass, i);
        // What the surface keeps in the mean of what a microfacet scatters. From inside, only the
        // cone that total reflection leaves passes.
        let eta = to.eta[i].min(1.0);
        let passed = (Vec3::ONE - f0) * ((1.0 - found.glass_curve.0[i]) * eta * eta);
        let kept = passed * (Vec3::ONE - tint);
        let kept = if parameters.thin[i] != 0.0 { Vec3::ZERO } else { kept };
        let boost = boost(Vec3::ONE - kept, albedos);
        let reflected = f0 + (Vec3::ONE - f0) * between(cos.0[i], to.eta[i]);
        let albedo = (reflected + (Vec3::ONE - reflected) * tint) * albedos[0];
        set(&mut to.share, i, above * boost * amount, albedo);
        left.set(i, above * (1.0 - amount));
    }
}

/// Light that rough gloss keeps from the base without reflecting it. Blender's gloss of roughness 0.5
/// keeps 0.0086 at 80 degrees, for want of nodes in a table. This is half of that: albedos are
/// within 0.5 % of Blender's, and white surfaces within 0.5 % of white.
#[inline(always)]
fn withheld(cos: f32, roughness: f32) -> f32 {
    let slant = 1.0 - cos;
    0.0039
        * (1.5 * slant * slant).min(1.0)
        * (6.0 * cos).min(1.0)
        * (4.0 * roughness).clamp(0.0, 1.0)
}

#[inline(always)]
fn specular(
    parameters: &Parameters,
    found: &Found,
    cos: &Numbers,
    len: usize,
    left: &mut Vec3s,
    to: &mut Specular,
) {
    for i in lanes(len) {
        let above = left.get(i);
        let eta = to.eta[i];
        let f0 = parameters.specular_tint.get(i) * normal_incidence(eta);
        to.f0.set(i, f0);
        let albedos = at_hit(&found.base, i);
        let [curve, mean] = at_hit(&found.base_curve, i);
        let boost = boost(f0 + (Vec3::ONE - f0) * mean, albedos);
        let albedo = (f0 + (Vec3::ONE - f0) * curve) * albedos[0];
        // An index of 1 leaves nothing to reflect.
        let is_there = eta != 1.0;
        set(&mut to.facets.share, i, if is_there { above * boost } else { Vec3::ZERO }, albedo);
        let lost = withheld(cos.0[i], parameters.roughness[i]);
        let taken = ((albedo * boost).max_element() + lost).clamp(0.0, 1.0);
        left.set(i, above * (1.0 - if is_there { taken } else { 0.0 }));
    }
}

#[inline(always)]
fn diffuse(
    parameters: &Parameters,
    views: &Views,
    is_mine: &impl Fn(usize) -> bool,
    len: usize,
    smooth: &mut Diffuse,
    rough: &mut RoughDiffuse,
) {
    let share = &mut smooth.0;
    let kept = if share.is_present { 1.0 } else { 0.0 };
    for i in lanes(len) {
        let color = parameters.base_color.get(i);
        let weight = views.left.get(i) * color;
        let roughness = parameters.diffuse_roughness[i].clamp(0.0, 1.0);
        let is_rough = roughness > 0.0;
        let albedo = rough.set(i, color, roughness, views.cos_shading.0[i]);
        set(&mut rough.share, i, if is_rough { weight } else { Vec3::ZERO }, albedo);
        let before = (share.weight.get(i) * kept, share.chance[i] * kept);
        set(share, i, if is_rough { Vec3::ZERO } else { weight }, Vec3::ONE);
        let now = (share.weight.get(i), share.chance[i]);
        let (weight, chance) = if is_mine(i) { now } else { before };
        share.weight.set(i, weight);
        share.chance[i] = chance;
    }
}

/// Copies frames and widths to the lobes of microfacets.
#[inline(always)]
fn place(parameters: &Parameters, views: &Views, len: usize, to: &mut Bsdf) {
    let Bsdf { coat, metal, glass, specular, .. } = to;
    for i in lanes(len) {
        let (normal, x) = (views.normal.get(i), views.x.get(i));
        let base = widths(parameters.roughness[i], parameters.anisotropic[i]);
        let isotropic = widths(parameters.coat_roughness[i], 0.0);
        put(&mut coat.facets, i, normal, x, isotropic);
        put(&mut metal.facets, i, normal, x, base);
        put(&mut specular.facets, i, normal, x, base);
        glass.normal.set(i, normal);
    }
}

#[inline(always)]
fn put(to: &mut Facets, i: usize, normal: Vec3, x: Vec3, alpha: [f32; 2]) {
    to.normal.set(i, normal);
    to.x.set(i, x);
    to.alpha[0][i] = alpha[0];
    to.alpha[1][i] = alpha[1];
}

/// Whether any hit has the lobe.
#[inline(always)]
fn is_any(share: &Share, len: usize) -> bool {
    share.chance[..len].iter().fold(false, |any, &chance| any | (chance > 0.0))
}
