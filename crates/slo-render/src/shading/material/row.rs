//! What is known of every material at a hit, whatever its kind.

use glam::Vec3;

use slo_scene::TextureUse;

/// A material, ready for shading: a row of the material table.
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
