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
use super::tables::{TABLES, Tables};
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
        gloss_index(parameters, len, &mut to.specular.eta);
        let layers = Layers::of(parameters, &to.specular.eta, &is_mine, len);
        let (mut views, mut found) = (Views::default(), Found::default());
        look(&at, &is_mine, len, &mut views);
        if layers.any_facets() {
            look_at_facets(parameters, &at, len, &mut views);
        }
        let Views { left, cos, cos_shading, .. } = &mut views;
        if layers.sheen {
            sheen(parameters, cos_shading, len, left, &mut to.sheen);
        }
        if layers.coat {
            found.look_up_coat(tables, parameters, cos, len, &mut to.coat.eta);
            coat(parameters, cos, &found, len, left, &mut to.coat);
        }
        for i in lanes(len) {
            emitted.set(i, left.get(i));
        }
        if layers.any_base() {
            single(tables, &parameters.roughness, cos, len, &mut found.base);
        }
        if layers.metal {
            metal(parameters, &found, cos, len, left, &mut to.metal);
        }
        if layers.glass {
            found.look_up_glass(tables, parameters, from_outside, cos, len, &mut to.glass.eta);
            glass(parameters, &found, cos, len, left, &mut to.glass);
        }
        if layers.gloss {
            let eta = &to.specular.eta;
            curve(tables, eta, &parameters.roughness, cos, len, &mut found.base_curve);
            specular(parameters, &found, cos, len, left, &mut to.specular);
        }
        if layers.rough {
            rough_diffuse(parameters, &views, len, &mut to.rough_diffuse);
        }
        diffuse(parameters, &views, &is_mine, len, &mut to.diffuse);
        place(parameters, &views, layers, len, to);
        for (share, is_layer) in [
            (to.sheen.share_mut(), layers.sheen),
            (to.coat.share_mut(), layers.coat),
            (to.metal.share_mut(), layers.metal),
            (to.glass.share_mut(), layers.glass),
            (to.specular.share_mut(), layers.gloss),
            (to.rough_diffuse.share_mut(), layers.rough),
            (to.diffuse.share_mut(), true),
        ] {
            share.is_present = is_layer && is_any(share, len);
        }
    }
}

/// Which layers any hit of a batch has. The others would change nothing, and are left out.
#[derive(Clone, Copy, Debug, Default)]
struct Layers {
    sheen: bool,
    coat: bool,
    metal: bool,
    glass: bool,
    gloss: bool,
    /// Whether any diffuse base is rough.
    rough: bool,
}

impl Layers {
    /// Finds the layers of hits for which `is_mine`. `eta` are the indices of their gloss.
    #[inline(always)]
    fn of(
        parameters: &Parameters,
        eta: &Column<f32>,
        is_mine: &impl Fn(usize) -> bool,
        len: usize,
    ) -> Self {
        let mut any = Self::default();
        for (i, eta) in eta.iter().enumerate().take(len) {
            let is_mine = is_mine(i);
            any.sheen |= is_mine & (parameters.sheen[i] != 0.0);
            any.coat |= is_mine & (parameters.coat[i] != 0.0);
            any.metal |= is_mine & (parameters.metallic[i] != 0.0);
            any.glass |= is_mine & (parameters.transmission[i] != 0.0);
            any.gloss |= is_mine & (*eta != 1.0);
            any.rough |= is_mine & (parameters.diffuse_roughness[i] > 0.0);
        }
        any
    }

    /// Whether any layer is made of microfacets.
    fn any_facets(self) -> bool {
        self.coat || self.any_base()
    }

    /// Whether any layer is made of microfacets of the material's own roughness.
    fn any_base(self) -> bool {
        self.metal || self.glass || self.gloss
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
fn look(at: &impl Fn(usize) -> At, is_mine: &impl Fn(usize) -> bool, len: usize, to: &mut Views) {
    for i in lanes(len) {
        let At { eye, n, .. } = at(i);
        to.cos_shading.0[i] = n.dot(eye).clamp(0.0, 1.0);
        to.left.set(i, if is_mine(i) { Vec3::ONE } else { Vec3::ZERO });
    }
}

/// Finds the frames of microfacets.
#[inline(always)]
fn look_at_facets(parameters: &Parameters, at: &impl Fn(usize) -> At, len: usize, to: &mut Views) {
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
    }
}

/// The index of refraction of a material.
#[inline(always)]
fn ior(parameters: &Parameters, i: usize) -> f32 {
    parameters.ior[i].clamp(0.01, 100.0)
}

/// Computes the relative indices of refraction of gloss; 1 where there is none.
#[inline(always)]
fn gloss_index(parameters: &Parameters, len: usize, to: &mut Column<f32>) {
    for i in lanes(len) {
        let ior = ior(parameters, i);
        let level = parameters.specular_ior_level[i];
        let levelled = index_of(normal_incidence(ior) * 2.0 * level);
        let levelled = if level == 0.5 { ior.max(1.0 / ior) } else { levelled };
        to[i] = if ior < 1.0 { 1.0 / levelled } else { levelled };
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
    /// Looks up the albedos of coats, and sets their indices.
    #[inline(always)]
    fn look_up_coat(
        &mut self,
        tables: &Tables,
        parameters: &Parameters,
        cos: &Numbers,
        len: usize,
        eta: &mut Column<f32>,
    ) {
        let roughness = &parameters.coat_roughness;
        for i in lanes(len) {
            eta[i] = parameters.coat_ior[i].clamp(1.0, 100.0);
        }
        single(tables, roughness, cos, len, &mut self.coat);
        curve(tables, eta, roughness, cos, len, &mut self.coat_curve);
    }

    /// Looks up the albedos of glass, and sets its indices. Those of gloss must be known.
    #[inline(always)]
    fn look_up_glass(
        &mut self,
        tables: &Tables,
        parameters: &Parameters,
        from_outside: &Column<u32>,
        cos: &Numbers,
        len: usize,
        eta: &mut Column<f32>,
    ) {
        let (cos, roughness) = (&cos.0, &parameters.roughness);
        let mut any_inside = false;
        for i in lanes(len) {
            let (ior, is_thin) = (ior(parameters, i), parameters.thin[i] != 0.0);
            let is_inside = (from_outside[i] == 0) & !is_thin;
            eta[i] = if is_inside { 1.0 / ior } else { ior };
            let is_seen = (i < len) & (parameters.transmission[i] > 0.0) & !is_thin;
            any_inside |= is_seen & (eta[i] < 1.0) & (roughness[i] >= LEAST_ROUGHNESS);
            let body = tables.outside();
            let single = body.single(eta[i], roughness[i], cos[i]);
            let mean = body.mean(eta[i], roughness[i]);
            self.glass_curve.0[i] = tables.curve_mean(eta[i]);
            self.glass[0].0[i] = if is_thin { self.base[0].0[i] } else { single };
            self.glass[1].0[i] = if is_thin { self.base[1].0[i] } else { mean };
        }
        if any_inside {
            let inside = tables.inside();
            for i in lanes(len) {
                let is_inside = (eta[i] < 1.0) & (parameters.thin[i] == 0.0);
                let single = inside.single(eta[i], roughness[i], cos[i]);
                let mean = inside.mean(eta[i], roughness[i]);
                let [before, mean_before] = at_hit(&self.glass, i);
                self.glass[0].0[i] = if is_inside { single } else { before };
                self.glass[1].0[i] = if is_inside { mean } else { mean_before };
            }
        }
        for i in lanes(len) {
            let alpha = widths(roughness[i], 0.0)[0];
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
    cos: &Numbers,
    len: usize,
    [single, mean]: &mut [Numbers; 2],
) {
    for i in lanes(len) {
        let is_perfect = roughness[i] < LEAST_ROUGHNESS;
        let found = tables.single(roughness[i], cos.0[i]).max(0.01);
        single.0[i] = if is_perfect { 1.0 } else { found };
        mean.0[i] = tables.mean(roughness[i]);
    }
}

#[inline(always)]
fn curve(
    tables: &Tables,
    eta: &Column<f32>,
    roughness: &Column<f32>,
    cos: &Numbers,
    len: usize,
    [curve, mean]: &mut [Numbers; 2],
) {
    for i in lanes(len) {
        let perfect = between(cos.0[i], eta[i]);
        let found = tables.curve(eta[i], roughness[i], cos.0[i]);
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

/// The roughness of a diffuse base.
#[inline(always)]
fn diffuse_roughness(parameters: &Parameters, i: usize) -> f32 {
    parameters.diffuse_roughness[i].clamp(0.0, 1.0)
}

#[inline(always)]
fn rough_diffuse(parameters: &Parameters, views: &Views, len: usize, to: &mut RoughDiffuse) {
    for i in lanes(len) {
        let color = parameters.base_color.get(i);
        let roughness = diffuse_roughness(parameters, i);
        let albedo = to.set(i, color, roughness, views.cos_shading.0[i]);
        let weight = if roughness > 0.0 { views.left.get(i) * color } else { Vec3::ZERO };
        set(&mut to.share, i, weight, albedo);
    }
}

#[inline(always)]
fn diffuse(
    parameters: &Parameters,
    views: &Views,
    is_mine: &impl Fn(usize) -> bool,
    len: usize,
    to: &mut Diffuse,
) {
    let share = &mut to.0;
    let kept = if share.is_present { 1.0 } else { 0.0 };
    for i in lanes(len) {
        let weight = views.left.get(i) * parameters.base_color.get(i);
        let is_rough = diffuse_roughness(parameters, i) > 0.0;
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
fn place(parameters: &Parameters, views: &Views, layers: Layers, len: usize, to: &mut Bsdf) {
    let Bsdf { coat, metal, glass, specular, .. } = to;
    let base = |i: usize| widths(parameters.roughness[i], parameters.anisotropic[i]);
    if layers.coat {
        let isotropic = |i: usize| widths(parameters.coat_roughness[i], 0.0);
        put(views, len, isotropic, &mut coat.facets);
    }
    if layers.metal {
        put(views, len, base, &mut metal.facets);
    }
    if layers.gloss {
        put(views, len, base, &mut specular.facets);
    }
    if layers.glass {
        for i in lanes(len) {
            glass.normal.set(i, views.normal.get(i));
        }
    }
}

#[inline(always)]
fn put(views: &Views, len: usize, alpha: impl Fn(usize) -> [f32; 2], to: &mut Facets) {
    for i in lanes(len) {
        let alpha = alpha(i);
        to.normal.set(i, views.normal.get(i));
        to.x.set(i, views.x.get(i));
        to.alpha[0][i] = alpha[0];
        to.alpha[1][i] = alpha[1];
    }
}

/// Whether any hit has the lobe.
#[inline(always)]
fn is_any(share: &Share, len: usize) -> bool {
    share.chance[..len].iter().fold(false, |any, &chance| any | (chance > 0.0))
}
