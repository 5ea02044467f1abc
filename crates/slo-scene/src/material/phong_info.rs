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

impl Default for PhongInfo {
    /// What an empty `phong_info` says: a black surface.
    fn default() -> Self {
        Self {
            ambient: [0.0; 3],
            diffuse: [0.0; 3],
            specular: [0.0; 3],
            shininess: 0.0,
            reflectance: 0.0,
            diffuse_reflection: 0.0,
            refraction: 0.0,
            diffuse_refraction: 0.0,
            refraction_index: 1.0,
        }
    }
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
    let mut number = |name, to: &mut f32| {
        *to = fields.number_f32(name, Bound::NotNegative).unwrap_or(*to);
    };
    let mut info = PhongInfo::default();
    number("shininess", &mut info.shininess);
    number("reflectance", &mut info.reflectance);
    number("diffuse_reflection", &mut info.diffuse_reflection);
    number("refraction", &mut info.refraction);
    number("diffuse_refraction", &mut info.diffuse_refraction);
    let mut color = |name, to: &mut [f32; 3]| *to = fields.color(name).unwrap_or(*to);
    color("ambient", &mut info.ambient);
    color("diffuse", &mut info.diffuse);
    color("specular", &mut info.specular);
    let index = fields.number_f32("refraction_index", Bound::Positive);
    info.refraction_index = index.unwrap_or(info.refraction_index);
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
