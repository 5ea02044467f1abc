//! What every kind of material must say of itself.

use super::id::MaterialId;
use super::palette::Palette;
use super::texture::TextureId;
use crate::attributes::Fields;
use crate::kinds::Keyword;

/// A material of some kind, without what it contains.
pub(super) trait Look {
    /// Whether a surface can be seen without light on it.
    fn glows(&self) -> bool;

    /// Hands each image that the material shows to `put`; one may come several times.
    fn for_images(&self, put: &mut dyn FnMut(TextureId));

    /// Whether photons follow it: it reflects or refracts sharply somewhere.
    fn is_sharp(&self) -> bool {
        false
    }

    /// Whether an image bends its normals, for which meshes need tangents.
    fn bends_normals(&self) -> bool {
        false
    }

    /// The materials that it mixes.
    fn parts(&self) -> Option<[MaterialId; 2]> {
        None
    }
}

/// A kind of material that has elements of the language.
pub(super) trait WrittenMaterial: Look + Sized {
    /// The elements, and what they take.
    const KEYWORDS: &'static [Keyword];

    /// Reads one of the elements; `None` if something is wrong, which is reported.
    fn read<'a>(fields: &mut Fields<'_, 'a, '_>, palette: &mut Palette<'_, 'a>) -> Option<Self>;
}
