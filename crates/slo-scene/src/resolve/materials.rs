//! Materials, and the phong_infos that they are made of.

use super::fields::Fields;
use super::oddities;
use super::values::Bound;
use crate::Material;

/// `phong_info`, as a material of its name without a texture.
pub(super) fn phong_info(fields: &mut Fields<'_, '_, '_>) -> Material {
    let mut number = |name| fields.number_f32(name, Bound::NotNegative).unwrap_or(0.0);
    let shininess = number("shininess");
    let reflectance = number("reflectance");
    let diffuse_reflection = number("diffuse_reflection");
    let refraction = number("refraction");
    let diffuse_refraction = number("diffuse_refraction");
    let material = Material {
        name: fields.element.name.text.to_owned(),
        ambient: fields.color("ambient").unwrap_or_default(),
        diffuse: fields.color("diffuse").unwrap_or_default(),
        specular: fields.color("specular").unwrap_or_default(),
        shininess,
        reflectance,
        diffuse_reflection,
        refraction,
        diffuse_refraction,
        refraction_index: fields.number_f32("refraction_index", Bound::Positive).unwrap_or(1.0),
        texture: None,
    };
    oddities::check_phong_info(fields, &material);
    material
}

/// `scale_U` and `scale_V` of a `material_texture`.
pub(super) fn texture_scale(fields: &mut Fields<'_, '_, '_>) -> [f32; 2] {
    ["scale_U", "scale_V"].map(|name| fields.number_f32(name, Bound::Any).unwrap_or(1.0))
}
