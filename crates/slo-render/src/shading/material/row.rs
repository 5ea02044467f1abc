//! The numbers of a Phong material at a hit.

use glam::Vec3;

use slo_scene::TextureUse;

/// A Phong material prepared for shading: a row of the material table. A material of another kind
/// has a row of zeros.
#[derive(Clone, Copy, Debug, Default)]
pub struct Material {
    /// k_a, RGB.
    pub ambient: Vec3,
    /// k_d, RGB.
    pub diffuse: Vec3,
    /// k_s, RGB.
    pub specular: Vec3,
    /// Exponent of the highlight.
    pub shininess: f32,
    /// k_r, the reflected share of light.
    pub reflectance: f32,
    /// k_t, the refracted share of light.
    pub refraction: f32,
    /// `1 / (n + 1)` of the reflected lobe cos^n; 0 for a perfect mirror.
    pub reflection_lobe: f32,
    /// `1 / (n + 1)` of the refracted lobe cos^n; 0 for clear glass.
    pub refraction_lobe: f32,
    /// Index of refraction inside the object; outside it is 1.
    pub refraction_index: f32,
    /// Image that multiplies `ambient` and `diffuse`.
    pub texture: Option<TextureUse>,
}
