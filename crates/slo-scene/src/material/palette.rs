//! What materials refer to.

use super::phong_info::PhongInfo;
use super::texture::TextureId;
use crate::attributes::{References, Referred};
use crate::format::syntax::Word;

/// The elements that a material may refer to.
pub(crate) struct Palette<'r, 'a> {
    pub(crate) references: &'r mut References<'a>,
    /// By the index of the `phong_info`.
    pub(crate) phong_infos: &'r [PhongInfo],
}

impl<'a> Palette<'_, 'a> {
    /// The `phong_info` of a name; notes a missing one.
    pub(crate) fn phong_info(&mut self, name: Word<'a>) -> Option<&PhongInfo> {
        self.phong_infos.get(self.references.find(Referred::PhongInfo, name)?)
    }

    /// The texture of a name; notes a missing one.
    pub(crate) fn texture(&mut self, name: Word<'a>) -> Option<TextureId> {
        let index = self.references.find(Referred::Texture, name)?;
        Some(TextureId(index as u32))
    }
}
