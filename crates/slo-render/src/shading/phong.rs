//! The local part of the thesis's lighting model.

use glam::Vec3;

use crate::sampling::warp::lobe_inverse;
use slo_accel::math::elementary::power;
use slo_scene::{self, TextureUse};

/// A material, ready for shading.
#[derive(Clone, Copy, Debug)]
pub struct Material {
    /// k_a
    pub ambient: Vec3,
    /// k_d
    pub diffuse: Vec3,
    /// k_s
    pub specular: Vec3,
    /// Exponent of the highlight.
    pub shininess: f32,
    /// k_r
    pub reflectance: f32,
    /// k_t
    pub refraction: f32,
    /// `1 / (n + 1)` of the reflected lobe cos^n; 0: mirror.
    pub reflection_lobe: f32,
    /// `1 / (n + 1)` of the refracted lobe cos^n; 0: clear.
    pub refraction_lobe: f32,
    /// Index of refraction inside, 1 outside.
    pub refraction_index: f32,
    /// Multiplies ambient and diffuse.
    pub texture: Option<TextureUse>,
}

impl From<&slo_scene::Material> for Material {
    fn from(m: &slo_scene::Material) -> Self {
        Self {
            ambient: m.ambient.into(),
            diffuse: m.diffuse.into(),
            specular: m.specular.into(),
            shininess: m.shininess,
            reflectance: m.reflectance,
            refraction: m.refraction,
            reflection_lobe: lobe_inverse(m.diffuse_reflection),
            refraction_lobe: lobe_inverse(m.diffuse_refraction),
            refraction_index: m.refraction_index,
            texture: m.texture,
        }
    }
}

/// What a light of radiance 1 in direction `l` adds toward `e`: k_d (L.N) + k_s (E.R)^shininess,
/// without any distance. `n`, `l`, `e` are unit and point away from the surface; 0 where the light
/// is behind `n`. Without branches; `SHINES` is false where all of `specular` is 0.
///
/// Source: thesis 2.15.
#[inline(always)]
pub fn local_light<const SHINES: bool>(
    [diffuse, specular]: [Vec3; 2],
    shininess: f32,
    n: Vec3,
    l: Vec3,
    e: Vec3,
) -> Vec3 {
    let cos = n.dot(l);
    let mut light = diffuse * cos;
    if SHINES {
        let highlight = (2.0 * cos * n - l).dot(e).max(0.0);
        // x^0 is 1 for every x.
        let power = if shininess == 0.0 { 1.0 } else { power(highlight, shininess) };
        light += specular * power;
    }
    if cos > 0.0 { light } else { Vec3::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPECULAR: Vec3 = Vec3::splat(0.5);

    fn light(diffuse: Vec3, l: Vec3, e: Vec3) -> Vec3 {
        local_light::<true>([diffuse, SPECULAR], 10.0, Vec3::Z, l, e)
    }

    #[test]
    fn terms_are_those_of_the_thesis() {
        let (s, c) = (0.6f32, 0.8f32);
        let l = Vec3::new(s, 0.0, c);
        // Seen from the mirrored direction the highlight is at its peak.
        let diffuse = Vec3::new(0.5, 0.25, 0.0);
        let at_peak = light(diffuse, l, Vec3::new(-s, 0.0, c));
        assert!((at_peak - Vec3::new(0.9, 0.7, 0.5)).length() < 1e-6, "{at_peak}");
        // Seen along the normal E.R is 0.8.
        let from_above = light(Vec3::new(0.5, 0.0, 0.0), l, Vec3::Z);
        let highlight = 0.5 * 0.107_374_18;
        let expected = Vec3::new(0.4 + highlight, highlight, highlight);
        assert!((from_above - expected).length() < 1e-6, "{from_above}");
    }

    #[test]
    fn matte_surfaces_need_no_power() {
        let (l, e) = (Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.0, 0.6, 0.8));
        let matte = local_light::<false>([Vec3::ONE, Vec3::ZERO], 7.0, Vec3::Z, l, e);
        assert_eq!(matte, local_light::<true>([Vec3::ONE, Vec3::ZERO], 7.0, Vec3::Z, l, e));
    }

    #[test]
    fn a_light_behind_the_surface_adds_nothing() {
        let l = Vec3::new(0.6, 0.0, -0.8);
        assert_eq!(light(Vec3::ONE, l, l), Vec3::ZERO);
    }
}
