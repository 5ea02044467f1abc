//! What every kind of light must say of itself.

use crate::attributes::Fields;
use crate::kinds::Keyword;
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
    fn read(fields: &mut Fields<'_, '_, '_>, _: &mut ()) -> Option<Self>;
}
