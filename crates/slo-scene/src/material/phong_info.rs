//! `phong_info`: numbers that several materials may share.

use crate::attributes::schema::{Schema, color, number};
use crate::attributes::{Bound, Fields, Value, looks_like_bytes};
use crate::diagnostics::Diagnostic;

/// How much more light than arrives a material may give back by the rounding of its numbers.
const ROUNDING: f64 = 1e-3;

/// Numbers of the thesis's lighting model.
#[derive(Clone, Debug)]
pub struct PhongInfo {
    /// k_a
    pub ambient: [f32; 3],
    /// k_d
    pub diffuse: [f32; 3],
    /// k_s
    pub specular: [f32; 3],
    /// Exponent of the highlight.
    pub shininess: f32,
    /// k_r
    pub reflectance: f32,
    /// Spread of the reflected lobe; 0: mirror.
    pub diffuse_reflection: f32,
    /// k_t
    pub refraction: f32,
    /// Spread of the refracted lobe; 0: clear.
    pub diffuse_refraction: f32,
    /// Index of refraction inside; 1 outside. More than 0.
    pub refraction_index: f32,
}

/// `phong_info`, which materials refer to.
pub(crate) const PHONG_INFO: Schema = Schema::new(
    "phong_info",
    &[
        color("ambient"),
        color("diffuse"),
        color("specular"),
        number("shininess"),
        number("reflectance"),
        number("diffuse_reflection"),
        number("refraction"),
        number("diffuse_refraction"),
        number("refraction_index"),
    ],
);

/// Reads a `phong_info`.
pub(crate) fn phong_info(fields: &mut Fields<'_, '_, '_>) -> PhongInfo {
    let mut number = |name| fields.number_f32(name, Bound::NotNegative).unwrap_or(0.0);
    let shininess = number("shininess");
    let reflectance = number("reflectance");
    let diffuse_reflection = number("diffuse_reflection");
    let refraction = number("refraction");
    let diffuse_refraction = number("diffuse_refraction");
    let info = PhongInfo {
        ambient: fields.color("ambient").unwrap_or_default(),
        diffuse: fields.color("diffuse").unwrap_or_default(),
        specular: fields.color("specular").unwrap_or_default(),
        shininess,
        reflectance,
        diffuse_reflection,
        refraction,
        diffuse_refraction,
        refraction_index: fields.number_f32("refraction_index", Bound::Positive).unwrap_or(1.0),
    };
    check(fields, &info);
    info
}

/// Warns of a `phong_info` that gives back more light than arrives, or says what has no effect.
fn check(fields: &mut Fields<'_, '_, '_>, material: &PhongInfo) {
    let [mirrors, passes] = [material.reflectance > 0.0, material.refraction > 0.0];
    let dependent = [
        ("refraction_index", material.refraction_index != 1.0, "refraction", passes),
        ("diffuse_refraction", material.diffuse_refraction > 0.0, "refraction", passes),
        ("diffuse_reflection", material.diffuse_reflection > 0.0, "reflectance", mirrors),
        ("shininess", material.shininess > 0.0, "specular", material.specular != [0.0; 3]),
    ];
    for (name, is_given, needs, is_there) in dependent {
        let is_broken = |name| fields.get(name).is_some_and(|f| matches!(f.value, Value::Broken));
        let Some(field) = fields.get(name).filter(|_| is_given && !is_there && !is_broken(needs))
        else {
            continue;
        };
        let help = match needs {
            "specular" => "write `specular { r g b }`, the colour of the highlight",
            "refraction" => "write `refraction NUMBER`, the share of the light that passes through",
            _ => "write `reflectance NUMBER`, the share of the light that is mirrored",
        };
        let message = format!("`{name}` has no effect without `{needs}`");
        fields.diagnostics.push(Diagnostic::warning(message).at(field.keyword.span, "").help(help));
    }
    let diffuse = material.diffuse.into_iter().fold(0.0, f32::max);
    if let Some(field) = fields.get("diffuse")
        && f64::from(diffuse) > 1.0 + ROUNDING
        && !looks_like_bytes(material.diffuse)
    {
        let message = format!("`diffuse` reflects {diffuse} times the light that arrives");
        let warning = Diagnostic::warning(message).at(field.keyword.span, "");
        fields.diagnostics.push(warning.help("colours of surfaces are from 0 to 1"));
    }
    let sent = f64::from(material.reflectance) + f64::from(material.refraction);
    if sent > 1.0 + ROUNDING {
        let spans =
            ["reflectance", "refraction"].map(|name| fields.get(name)).into_iter().flatten();
        let mut spans = spans.map(|field| field.keyword.span);
        let Some(first) = spans.next() else { return };
        let message = format!("this passes on {sent:.3} times the light that arrives");
        let warning = Diagnostic::warning(message).at(first, "");
        let warning = spans.fold(warning, |warning, span| warning.also(span, "and this"));
        let help = "the picture gets brighter with each bounce; the sum should be 1 or less";
        fields.diagnostics.push(warning.help(help));
    }
}
