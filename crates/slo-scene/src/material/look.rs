//! What every kind of material must say of itself.

use super::palette::Palette;
use super::texture::TextureId;
use crate::attributes::Fields;
use crate::kinds::Keyword;

/// A material of some kind.
pub(super) trait Look {
    /// Whether a surface can be seen without light on it.
    fn glows(&self) -> bool;

    /// The image that it shows, if any.
    fn image(&self) -> Option<TextureId>;
}

/// A kind of material that has elements of the language.
pub(super) trait WrittenMaterial: Look + Sized {
    /// The elements, and what they take.
    const KEYWORDS: &'static [Keyword];

    /// Reads one of the elements; `None` if something is wrong, which is reported.
    fn read<'a>(fields: &mut Fields<'_, 'a, '_>, palette: &mut Palette<'_, 'a>) -> Option<Self>;
}
