//! Materials in columns, looked up at every hit.

use glam::Vec3;

use super::images::MaterialImages;
use super::kind::Kind;
use super::principled::{Constants, PrincipledTable};
use super::row::Material;
use slo_scene::MaterialKind;
use slo_scene::material::{Principled, Varying};

/// One number of every material, indexed by the material.
type Entries = Vec<f32>;

/// All numbers of materials except images, in columns; see [`Material`].
#[derive(Clone, Debug, Default)]
pub struct MaterialTable {
    /// One column each for red, green and blue.
    pub ambient: [Entries; 3],
    /// One column each for red, green and blue.
    pub diffuse: [Entries; 3],
    /// One column each for red, green and blue.
    pub specular: [Entries; 3],
    /// Whether any of `ambient` is not 0.
    pub has_ambient: bool,
    /// Whether any of `specular` is not 0.
    pub shines: bool,
    /// Exponents of highlights.
    pub shininess: Entries,
    /// k_r
    pub reflectance: Entries,
    /// k_t
    pub refraction: Entries,
    /// `1 / (n + 1)` of the lobe cos^n; 0 if perfect.
    pub reflection_lobe: Entries,
    /// `1 / (n + 1)` of the lobe cos^n; 0 if perfect.
    pub refraction_lobe: Entries,
    /// Indices of refraction inside the objects.
    pub refraction_index: Entries,
    /// Kind of each material.
    pub kinds: Vec<Kind>,
    /// Physical materials; empty if the scene has none.
    pub principled: PrincipledTable,
    /// What depends on images, and mixes.
    pub images: MaterialImages,
    /// Whether any material mixes others.
    pub has_mixes: bool,
    /// Whether any material emits light of its own.
    pub emits: bool,
    /// Whether any material absorbs light inside of its objects.
    pub absorbs: bool,
}

impl MaterialTable {
    /// Whether any material is physical.
    pub fn is_physical(&self) -> bool {
        self.kinds.contains(&Kind::Principled)
    }

    /// Arranges materials in columns.
    pub fn new(scene: &[slo_scene::Material], materials: &[Material]) -> Self {
        let kinds: Vec<Kind> = scene.iter().map(Kind::of).collect();
        let black = Principled { base_color: Varying::constant([0.0; 3]), ..Principled::default() };
        let constants = scene.iter().map(|material| match &material.kind {
            MaterialKind::Principled(principled) => Constants::new(principled),
            MaterialKind::Phong(_) | MaterialKind::Mix(_) => Constants::new(&black),
        });
        let is_physical = kinds.contains(&Kind::Principled);
        let constants: Vec<_> = constants.filter(|_| is_physical).collect();
        let all = |of: fn(&Material) -> f32| materials.iter().map(of).collect();
        Self {
            ambient: [all(|m| m.ambient.x), all(|m| m.ambient.y), all(|m| m.ambient.z)],
            diffuse: [all(|m| m.diffuse.x), all(|m| m.diffuse.y), all(|m| m.diffuse.z)],
            specular: [all(|m| m.specular.x), all(|m| m.specular.y), all(|m| m.specular.z)],
            has_ambient: materials.iter().any(|m| m.ambient != Vec3::ZERO),
            shines: materials.iter().any(|m| m.specular != Vec3::ZERO),
            shininess: all(|m| m.shininess),
            reflectance: all(|m| m.reflectance),
            refraction: all(|m| m.refraction),
            reflection_lobe: all(|m| m.reflection_lobe),
            refraction_lobe: all(|m| m.refraction_lobe),
            refraction_index: all(|m| m.refraction_index),
            emits: constants.iter().any(|m| m.emission != Vec3::ZERO),
            absorbs: constants.iter().any(|m| m.absorption != Vec3::ZERO),
            has_mixes: kinds.contains(&Kind::Mix),
            kinds,
            images: MaterialImages::new(scene),
            principled: PrincipledTable::new(&constants),
        }
    }
}
