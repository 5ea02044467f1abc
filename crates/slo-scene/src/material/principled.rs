//! `material_principled`: metal, dielectrics, coats, sheen, glass and glowing surfaces.

use super::SHARP;
use super::inputs::{inputs, warn_idle};
use super::look::{Look, WrittenMaterial};
use super::palette::Palette;
use super::texture::{ImageUse, TextureId};
use super::varying::{ColorOf, Quantity, Varying, read_varying};
use super::written_image::{IMAGE, NORMALS, Purpose, read_image};
use crate::attributes::schema::{Attribute, Schema, absent, color, number, word_or_block};
use crate::attributes::{Bound, Fields};
use crate::kinds::Keyword;

inputs! {
    /// A physical surface. Names and meaning follow Blender's Principled BSDF.
    pub struct Principled {
        /// Albedo of the diffuse part, reflectance of the metal, tint of transmitted light.
        base_color: [f32; 3] = [0.8; 3], in ColorOf::Surface,
            also ["color", "albedo", "diffuse", "diffuse_color", "base_color_factor"];
        /// Share of metal.
        metallic: f32 = 0.0, in Bound::Share,
            also ["metalness", "metal", "metallic_factor", "base_metalness"];
        /// Roughness of the reflection; 0 is a perfect mirror. GGX's alpha is its square.
        roughness: f32 = 0.5, in Bound::Share, also ["roughness_factor", "specular_roughness"];
        /// Roughness of the diffuse part; 0 is Lambert.
        diffuse_roughness: f32 = 0.0, in Bound::Share, also ["base_diffuse_roughness"];
        /// Index of refraction inside.
        ior: f32 = 1.5, in Bound::AtLeastOne,
            also ["eta", "int_ior", "specular_ior", "refraction_index"];
        /// Share of the surface that is there; the rest lets light through unbent.
        alpha: f32 = 1.0, in Bound::Share, as Purpose::Alpha,
            also ["opacity", "geometry_opacity"];
        /// How far `normal_texture` bends the normals.
        normal_strength: f32 = 1.0, in Bound::NotNegative, also ["normal_scale", "bump_strength"];
        /// Scales the reflectance at normal incidence by twice its value.
        specular_ior_level: f32 = 0.5, in Bound::Share,
            also ["specular", "specular_weight", "specular_factor"];
        /// Tint of the dielectric's reflection, and of the metal's at grazing angles.
        specular_tint: [f32; 3] = [1.0; 3], in ColorOf::Surface,
            also ["specular_color", "spec_tint", "specular_color_factor"];
        /// How much longer reflections are along the surface's tangent.
        anisotropic: f32 = 0.0, in Bound::Share, needs roughness,
            also ["anisotropy", "anisotropy_strength", "specular_roughness_anisotropy"];
        /// Turns the tangent about the normal; 1 is a full turn.
        anisotropic_rotation: f32 = 0.0, in Bound::Share, needs anisotropic,
            also ["anisotropy_rotation"];
        /// Share of the dielectric that light passes through.
        transmission: f32 = 0.0, in Bound::Share,
            also ["transmission_weight", "transmission_factor", "spec_trans", "refraction"];
        /// Share of the surface that is coated.
        coat: f32 = 0.0, in Bound::Share,
            also ["clearcoat", "coat_weight", "clearcoat_factor"];
        /// Roughness of the coat.
        coat_roughness: f32 = 0.03, in Bound::Share, needs coat,
            also ["clearcoat_roughness", "clearcoat_roughness_factor"];
        /// Index of refraction of the coat.
        coat_ior: f32 = 1.5, in Bound::AtLeastOne, needs coat, also ["clearcoat_ior"];
        /// What the coat leaves of the light from below.
        coat_tint: [f32; 3] = [1.0; 3], in ColorOf::Surface, needs coat,
            also ["coat_color", "clearcoat_tint"];
        /// Share of the surface that is covered by fibres.
        sheen: f32 = 0.0, in Bound::Share, also ["sheen_weight", "fuzz", "fuzz_weight"];
        /// Roughness of the fibres.
        sheen_roughness: f32 = 0.5, in Bound::Share, needs sheen,
            also ["fuzz_roughness", "sheen_roughness_factor"];
        /// Colour of the fibres.
        sheen_tint: [f32; 3] = [1.0; 3], in ColorOf::Surface, needs sheen,
            also ["sheen_color", "fuzz_color", "sheen_color_factor"];
        /// Colour of the light that both sides emit.
        emission_color: [f32; 3] = [1.0; 3], in ColorOf::Light, needs emission_strength,
            also ["emission", "emissive", "emissive_color", "emissive_factor"];
        /// Multiplies `emission_color`: radiance, W/(m² sr).
        emission_strength: f32 = 0.0, in Bound::NotNegative, needs emission_color,
            also ["emissive_strength", "emissive_intensity", "emission_luminance"];
    } with {
        /// Normals in tangent space, as an image.
        normal: Option<ImageUse> = None,
        /// What is left of light after `absorption_distance` inside the object.
        absorption_color: [f32; 3] = [1.0; 3],
        /// Scene units; 0: nothing is absorbed.
        absorption_distance: f64 = 0.0,
        /// Whether the object is a pane without thickness, which light passes through unbent.
        thin: bool = false,
    }
}

/// What to say about `subsurface`.
const NO_SUBSURFACE: &str =
    "light that scatters below the surface is not computed: use `base_color`, or `transmission`";

/// What to say about `thin_film`.
const NO_THIN_FILM: &str = "thin films are not computed: `specular_tint` colours the reflection";

impl Principled {
    /// The attributes beside the inputs.
    const OTHERS: &'static [Attribute] = &[
        word_or_block("NAME", &Schema::new("normal_texture", NORMALS)).elsewhere(&[
            "normal",
            "normal_map",
            "bump",
            "bump_texture",
            "bump_map",
        ]),
        color("absorption_color").elsewhere(&["attenuation_color", "transmission_color"]),
        number("absorption_distance").elsewhere(&["attenuation_distance", "transmission_depth"]),
        number("thin").elsewhere(&["thin_walled", "thin_wall", "geometry_thin_walled"]),
        absent("subsurface", NO_SUBSURFACE).elsewhere(&[
            "subsurface_weight",
            "subsurface_color",
            "subsurface_radius",
            "subsurface_scale",
            "subsurface_ior",
            "subsurface_anisotropy",
        ]),
        absent("thin_film", NO_THIN_FILM).elsewhere(&[
            "thin_film_weight",
            "thin_film_thickness",
            "thin_film_ior",
            "iridescence",
        ]),
    ];

    /// Warns of values that have no effect.
    fn check(&self, fields: &mut Fields<'_, '_, '_>) {
        self.check_inputs(fields);
        if self.normal.is_none() && self.normal_strength != Varying::constant(1.0) {
            warn_idle(fields, "normal_strength", "normal_texture");
        }
        let transmits = self.transmission.value > 0.0;
        let [is_colored, is_deep] =
            [self.absorption_color != [1.0; 3], self.absorption_distance > 0.0];
        if self.thin && !transmits {
            warn_idle(fields, "thin", "transmission");
        }
        match (is_colored, is_deep) {
            (true, _) if !transmits => warn_idle(fields, "absorption_color", "transmission"),
            (_, true) if !transmits => warn_idle(fields, "absorption_distance", "transmission"),
            (true, false) => warn_idle(fields, "absorption_color", "absorption_distance"),
            (false, true) => warn_idle(fields, "absorption_distance", "absorption_color"),
            _ => {}
        }
    }
}

impl WrittenMaterial for Principled {
    const KEYWORDS: &'static [Keyword] = &[Keyword {
        keyword: "material_principled",
        attributes: &concatenated::<{ Self::INPUTS.len() + Self::OTHERS.len() }>(
            Self::INPUTS,
            Self::OTHERS,
        ),
    }];

    fn read<'a>(fields: &mut Fields<'_, 'a, '_>, palette: &mut Palette<'_, 'a>) -> Option<Self> {
        let mut to = Self::default();
        to.read_inputs(fields, palette);
        to.normal = read_image(fields, palette, "normal_texture", Purpose::Normals);
        let color = <[f32; 3]>::read(fields, "absorption_color", ColorOf::Surface);
        to.absorption_color = color.unwrap_or(to.absorption_color);
        let distance = fields.length("absorption_distance", Bound::NotNegative);
        to.absorption_distance = distance.map_or(0.0, |found| found.value);
        to.thin = fields.count("thin", 0, 1).is_some_and(|flag| flag.value == 1);
        to.check(fields);
        Some(to)
    }
}

/// Two lists in one.
const fn concatenated<const N: usize>(a: &[Attribute], b: &[Attribute]) -> [Attribute; N] {
    let mut all = [a[0]; N];
    let mut i = 0;
    while i < N {
        all[i] = if i < a.len() { a[i] } else { b[i - a.len()] };
        i += 1;
    }
    all
}

impl Look for Principled {
    fn glows(&self) -> bool {
        self.emission_strength.value > 0.0 && self.emission_color.value != [0.0; 3]
    }

    fn is_sharp(&self) -> bool {
        // An image may darken a roughness to 0.
        let is_narrow = |roughness: &Varying<f32>| {
            roughness.image.is_some() || roughness.value * roughness.value < SHARP
        };
        let shines = self.metallic.value > 0.0
            || self.transmission.value > 0.0
            || (self.specular_ior_level.value > 0.0 && self.ior.value != 1.0);
        (shines && is_narrow(&self.roughness))
            || (self.coat.value > 0.0 && is_narrow(&self.coat_roughness))
    }

    fn for_images(&self, put: &mut dyn FnMut(TextureId)) {
        self.for_input_images(put);
        self.normal.iter().for_each(|normal| put(normal.texture));
    }

    fn bends_normals(&self) -> bool {
        self.normal.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_documentation_lists_all_inputs() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/scene-format.md");
        let page = std::fs::read_to_string(path).expect("the repository has the page");
        let rows = Principled::documentation();
        assert_eq!(rows.len() * 2, Principled::INPUTS.len());
        let missing: Vec<_> = rows.iter().filter(|row| !page.contains(*row)).collect();
        assert!(missing.is_empty(), "docs/scene-format.md lacks {missing:#?}");
    }
}
