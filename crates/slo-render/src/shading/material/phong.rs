//! `material_phong`, `material_texture`: the local part of the thesis's lighting model.

use glam::Vec3;

use super::row::Material;
use crate::sampling::warp::lobe_inverse;
use slo_accel::math::elementary::power;
use slo_scene::material::Phong;

/// Returns the row of a Phong material in the material table.
pub(super) fn row(Phong { info, texture }: &Phong) -> Material {
    Material {
        ambient: info.ambient.into(),
        diffuse: info.diffuse.into(),
        specular: info.specular.into(),
        shininess: info.shininess,
        reflectance: info.reflectance,
        refraction: info.refraction,
        reflection_lobe: lobe_inverse(info.diffuse_reflection),
        refraction_lobe: lobe_inverse(info.diffuse_refraction),
        refraction_index: info.refraction_index,
        texture: *texture,
    }
}

/// Returns the light reflected toward `e` from a light of radiance 1 in direction `l`: k_d (L.N) +
/// k_s (E.R)^shininess. The cosine is included in the first term only; there is no falloff with
/// distance. `n`, `l`, `e` are unit vectors that point away from the surface. The result is 0 if
/// the light is behind `n`. Free of branches; `SHINES` may be false if all of `specular` is 0.
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
        // Seen from the mirrored direction, the highlight is at its peak.
        let diffuse = Vec3::new(0.5, 0.25, 0.0);
        let at_peak = light(diffuse, l, Vec3::new(-s, 0.0, c));
        assert!((at_peak - Vec3::new(0.9, 0.7, 0.5)).length() < 1e-6, "{at_peak}");
        // Seen along the normal, E.R is 0.8.
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
