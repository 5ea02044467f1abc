//! `material_principled`: metal, dielectrics, coats, sheen, glass and glowing surfaces.

use super::look::{Look, WrittenMaterial};
use super::palette::Palette;
use super::texture::{ImageUse, TextureId};
use crate::attributes::schema::{color, number};
use crate::attributes::{Bound, Fields};
use crate::kinds::Keyword;

/// A value that may vary over a surface: a constant, multiplied by an image if there is one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Varying<T> {
    /// The constant.
    pub value: T,
    /// The image.
    pub image: Option<ImageUse>,
}

impl<T> Varying<T> {
    /// The same value everywhere.
    pub const fn constant(value: T) -> Self {
        Self { value, image: None }
    }
}

/// A physical surface. Names and meaning follow Blender's Principled BSDF.
#[derive(Clone, Debug, PartialEq)]
pub struct Principled {
    /// Albedo of the diffuse part, reflectance of the metal, tint of what is transmitted.
    pub base_color: Varying<[f32; 3]>,
    /// Share of metal, from 0 to 1.
    pub metallic: Varying<f32>,
    /// Square root of the alpha of GGX, from 0 to 1; 0 is perfect.
    pub roughness: Varying<f32>,
    /// Roughness of the diffuse part, from 0 (Lambert) to 1.
    pub diffuse_roughness: Varying<f32>,
    /// Index of refraction; more than 0.
    pub ior: Varying<f32>,
    /// Share of light that meets the surface, from 0 to 1; the rest passes through unbent.
    pub alpha: Varying<f32>,
    /// How far the image of normals bends them.
    pub normal_strength: Varying<f32>,
    /// Half the factor of the reflectance at normal incidence that `ior` gives.
    pub specular_ior_level: Varying<f32>,
    /// Tints the reflection of the dielectric, and that of the metal at grazing angles.
    pub specular_tint: Varying<[f32; 3]>,
    /// From 0 to 1.
    pub anisotropic: Varying<f32>,
    /// Turns about the normal.
    pub anisotropic_rotation: Varying<f32>,
    /// Share of the dielectric that light passes through, from 0 to 1.
    pub transmission: Varying<f32>,
    /// Share of the surface that is coated, from 0 to 1.
    pub coat: Varying<f32>,
    /// As `roughness`.
    pub coat_roughness: Varying<f32>,
    /// Index of refraction of the coat; 1 or more.
    pub coat_ior: Varying<f32>,
    /// What the coat absorbs of the light from below.
    pub coat_tint: Varying<[f32; 3]>,
    /// Share of the surface that is covered by fibres, from 0 to 1.
    pub sheen: Varying<f32>,
    /// Roughness of the fibres, from 0 to 1.
    pub sheen_roughness: Varying<f32>,
    /// Colour of the fibres.
    pub sheen_tint: Varying<[f32; 3]>,
    /// Colour of the light that both sides emit.
    pub emission_color: Varying<[f32; 3]>,
    /// Multiplies `emission_color`: radiance, W/(m² sr).
    pub emission_strength: Varying<f32>,
    /// Normals in tangent space, as an image.
    pub normal: Option<ImageUse>,
    /// What is left of light after `absorption_distance` inside the object.
    pub absorption_color: [f32; 3],
    /// Scene units; 0: nothing is absorbed.
    pub absorption_distance: f64,
    /// Whether the object is a pane without thickness, which light passes through unbent.
    pub thin: bool,
}

impl Default for Principled {
    fn default() -> Self {
        Self {
            base_color: Varying::constant([0.8; 3]),
            metallic: Varying::constant(0.0),
            roughness: Varying::constant(0.5),
            diffuse_roughness: Varying::constant(0.0),
            ior: Varying::constant(1.5),
            alpha: Varying::constant(1.0),
            normal_strength: Varying::constant(1.0),
            specular_ior_level: Varying::constant(0.5),
            specular_tint: Varying::constant([1.0; 3]),
            anisotropic: Varying::constant(0.0),
            anisotropic_rotation: Varying::constant(0.0),
            transmission: Varying::constant(0.0),
            coat: Varying::constant(0.0),
            coat_roughness: Varying::constant(0.03),
            coat_ior: Varying::constant(1.5),
            coat_tint: Varying::constant([1.0; 3]),
            sheen: Varying::constant(0.0),
            sheen_roughness: Varying::constant(0.5),
            sheen_tint: Varying::constant([1.0; 3]),
            emission_color: Varying::constant([1.0; 3]),
            emission_strength: Varying::constant(0.0),
            normal: None,
            absorption_color: [1.0; 3],
            absorption_distance: 0.0,
            thin: false,
        }
    }
}

impl WrittenMaterial for Principled {
    const KEYWORDS: &'static [Keyword] = &[Keyword {
        keyword: "material_principled",
        attributes: &[
            color("base_color"),
            number("metallic"),
            number("roughness"),
            number("diffuse_roughness"),
            number("ior"),
            number("alpha"),
            number("normal_strength"),
            number("specular_ior_level"),
            color("specular_tint"),
            number("anisotropic"),
            number("anisotropic_rotation"),
            number("transmission"),
            number("coat"),
            number("coat_roughness"),
            number("coat_ior"),
            color("coat_tint"),
            number("sheen"),
            number("sheen_roughness"),
            color("sheen_tint"),
            color("emission_color"),
            number("emission_strength"),
            color("absorption_color"),
            number("absorption_distance"),
            number("thin"),
        ],
    }];

    fn read<'a>(fields: &mut Fields<'_, 'a, '_>, _: &mut Palette<'_, 'a>) -> Option<Self> {
        let mut to = Self::default();
        let mut number = |name, to: &mut Varying<f32>| {
            to.value = fields.number_f32(name, Bound::NotNegative).unwrap_or(to.value);
        };
        number("metallic", &mut to.metallic);
        number("roughness", &mut to.roughness);
        number("diffuse_roughness", &mut to.diffuse_roughness);
        number("ior", &mut to.ior);
        number("alpha", &mut to.alpha);
        number("normal_strength", &mut to.normal_strength);
        number("specular_ior_level", &mut to.specular_ior_level);
        number("anisotropic", &mut to.anisotropic);
        number("anisotropic_rotation", &mut to.anisotropic_rotation);
        number("transmission", &mut to.transmission);
        number("coat", &mut to.coat);
        number("coat_roughness", &mut to.coat_roughness);
        number("coat_ior", &mut to.coat_ior);
        number("sheen", &mut to.sheen);
        number("sheen_roughness", &mut to.sheen_roughness);
        number("emission_strength", &mut to.emission_strength);
        let mut color = |name, to: &mut Varying<[f32; 3]>| {
            to.value = fields.color(name).unwrap_or(to.value);
        };
        color("base_color", &mut to.base_color);
        color("specular_tint", &mut to.specular_tint);
        color("coat_tint", &mut to.coat_tint);
        color("sheen_tint", &mut to.sheen_tint);
        color("emission_color", &mut to.emission_color);
        to.absorption_color = fields.color("absorption_color").unwrap_or(to.absorption_color);
        let distance = fields.length("absorption_distance", Bound::NotNegative);
        to.absorption_distance = distance.map_or(0.0, |found| found.value);
        to.thin = fields.count("thin", 0, 1).is_some_and(|flag| flag.value == 1);
        Some(to)
    }
}

impl Look for Principled {
    fn glows(&self) -> bool {
        self.emission_strength.value > 0.0 && self.emission_color.value != [0.0; 3]
    }

    fn image(&self) -> Option<TextureId> {
        self.base_color.image.map(|image| image.texture)
    }
}
