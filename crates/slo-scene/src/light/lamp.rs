//! What every kind of light must say of itself.

use crate::attributes::Fields;
use crate::kinds::Keyword;
use crate::material::Palette;
use crate::shape::Shape;

/// A light of some kind, in scene space.
pub(super) trait Lamp {
    /// Whether the light brings nothing.
    fn is_dark(&self) -> bool;

    /// The surface that shines, in scene space; `None` if no ray can hit the light.
    fn surface(&self) -> Option<Shape>;
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
    let scale = (1.0 / (std::f64::consts::PI * area)) as f32;
    let power = fields.color("power").map(|power| power.map(|p| p * scale));
    fields.color("radiance").or(power)
}
