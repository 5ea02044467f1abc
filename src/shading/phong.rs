//! The local part of the thesis's lighting model.

use glam::Vec3;

use crate::math::elementary::power;
use crate::sampling::warp::lobe_inverse;
use crate::scene::{self, TextureUse};

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

impl From<&scene::Material> for Material {
    fn from(m: &scene::Material) -> Self {
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

impl Material {
    /// What a light of radiance 1 in direction `l` adds toward `e`: k_d (L.N) + k_s (E.R)^shininess,
    /// without any distance. `n`, `l`, `e` are unit and point away from the surface; 0 where the
    /// light is behind `n`. `tint` is the colour of the image.
    ///
    /// Source: thesis 2.15.
    #[inline(always)]
    pub fn phong(&self, n: Vec3, l: Vec3, e: Vec3, tint: Vec3) -> Vec3 {
        let cos = n.dot(l);
        if cos <= 0.0 {
            return Vec3::ZERO;
        }
        let highlight = (2.0 * cos * n - l).dot(e).max(0.0);
        // x^0 is 1 for every x.
        let specular = if self.shininess == 0.0 { 1.0 } else { power(highlight, self.shininess) };
        self.diffuse * tint * cos + self.specular * specular
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn material() -> Material {
        Material {
            ambient: Vec3::ZERO,
            diffuse: Vec3::new(0.5, 0.25, 0.0),
            specular: Vec3::splat(0.5),
            shininess: 10.0,
            reflectance: 0.0,
            refraction: 0.0,
            reflection_lobe: 0.0,
            refraction_lobe: 0.0,
            refraction_index: 1.0,
            texture: None,
        }
    }

    #[test]
    fn terms_are_those_of_the_thesis() {
        let (s, c) = (0.6f32, 0.8f32);
        let l = Vec3::new(s, 0.0, c);
        // Seen from the mirrored direction the highlight is at its peak.
        let at_peak = material().phong(Vec3::Z, l, Vec3::new(-s, 0.0, c), Vec3::ONE);
        assert!((at_peak - Vec3::new(0.9, 0.7, 0.5)).length() < 1e-6, "{at_peak}");
        // Seen along the normal E.R is 0.8.
        let from_above = material().phong(Vec3::Z, l, Vec3::Z, Vec3::new(1.0, 0.0, 1.0));
        let highlight = 0.5 * 0.107_374_18;
        let expected = Vec3::new(0.4 + highlight, highlight, highlight);
        assert!((from_above - expected).length() < 1e-6, "{from_above}");
    }

    #[test]
    fn a_light_behind_the_surface_adds_nothing() {
        let l = Vec3::new(0.6, 0.0, -0.8);
        assert_eq!(material().phong(Vec3::Z, l, l, Vec3::ONE), Vec3::ZERO);
    }
}
