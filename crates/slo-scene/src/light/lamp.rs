//! What every kind of light must say of itself, and what several of them take.

use glam::DVec3;

use crate::attributes::schema::{Attribute, block, number, word};
use crate::attributes::{ADD_KFRAME, Bound, Fields, SHORTEST};
use crate::diagnostics::Diagnostic;
use crate::kinds::Keyword;
use crate::material::Palette;
use crate::shape::Shape;

/// Whether camera rays see the lamp.
pub(super) const CAMERA_VISIBLE: Attribute = number("camera_visible");

/// Whether the lamp stops rays.
pub(super) const SOLID: Attribute = number("solid");

/// The layer that holds the light.
pub(super) const LIGHT_GROUP: Attribute = word("light_group", "NAME");

/// How the lamp moves.
pub(super) const MOTION: Attribute = block(&ADD_KFRAME).repeated();

pub(super) use crate::attributes::REPEAT;

/// A light of some kind, in lamp space.
pub(super) trait Lamp {
    /// Whether the light brings nothing.
    fn is_dark(&self) -> bool;

    /// The surface that shines; `None` if no ray can hit the light, or if no shape is like it.
    fn surface(&self) -> Option<Shape>;

    /// Hands the flat parts of the surface to `put`, for as long as that returns true.
    fn for_flat_parts(&self, put: &mut dyn FnMut(&[DVec3]) -> bool) {
        if let Some(surface) = self.surface() {
            surface.for_flat_parts(put);
        }
    }
}

/// A kind of light that has an element of the language.
pub(super) trait WrittenLight: Lamp + Sized {
    /// The element, and what it takes.
    const KEYWORDS: &'static [Keyword];

    /// Reads the element; `None` if something is wrong, which is reported.
    fn read<'a>(fields: &mut Fields<'_, 'a, '_>, palette: &mut Palette<'_, 'a>) -> Option<Self>;
}

/// Reads the radiance of a lamp that glows evenly on a surface of `area`: `radiance`, or `power`
/// divided by pi times the area.
pub(super) fn radiance_of(fields: &mut Fields<'_, '_, '_>, area: f64) -> Option<[f32; 3]> {
    let name = fields.either(["power", "radiance"])?;
    let light = fields.light(name)?;
    if name == "radiance" {
        return Some(light.value);
    }
    let radiance = light.value.map(|power| f64::from(power) / (std::f64::consts::PI * area));
    if radiance.iter().any(|radiance| *radiance > f64::from(f32::MAX)) {
        let message = format!("{} is too small for its power", fields.element.title());
        let label = format!("its radiance would be more than {:e}", f32::MAX);
        fields.diagnostics.push(Diagnostic::error(message).at(light.span, label));
        return None;
    }
    Some(radiance.map(|radiance| radiance as f32))
}

/// Reads the `radius` of a lamp that is a point without it.
pub(super) fn radius_or_point(fields: &mut Fields<'_, '_, '_>) -> Option<f64> {
    let radius = match fields.get("radius") {
        None => 0.0,
        Some(_) => {
            let found = fields.length("radius", Bound::NotNegative)?;
            if found.value > 0.0 && found.value < SHORTEST {
                let message = format!("`radius` is less than {SHORTEST:e}");
                let error = Diagnostic::error(message).at(found.span, "");
                fields.diagnostics.push(error.help("0 is a point"));
                return None;
            }
            found.value
        }
    };
    if radius == 0.0 {
        warn_of_point(fields);
    }
    Some(radius)
}

/// Warns of what a lamp says about rays that hit it if none can.
fn warn_of_point(fields: &mut Fields<'_, '_, '_>) {
    for name in ["camera_visible", "solid"] {
        let is_no = fields.word(name).is_some_and(|word| word.text == "0");
        if let Some(field) = fields.get(name).filter(|_| is_no) {
            let message = format!("`{name}` has no effect without `radius`");
            let warning = Diagnostic::warning(message).at(field.keyword.span, "");
            fields.diagnostics.push(warning.help("this lamp is a point, which no ray can hit"));
        }
    }
}
