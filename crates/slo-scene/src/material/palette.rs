//! What materials refer to.

use std::sync::Arc;

use super::id::MaterialId;
use super::phong_info::PhongInfo;
use super::texture::TextureId;
use crate::attributes::{References, Referred};
use crate::format::syntax::Word;
use crate::texture::Texture;

/// The elements that a material may refer to.
pub(crate) struct Palette<'r, 'a> {
    pub(crate) references: &'r mut References<'a>,
    /// By the index of the `phong_info`.
    pub(crate) phong_infos: &'r [PhongInfo],
    /// By the index of the `texture`; `None` if it can't be loaded.
    pub(crate) textures: &'r [Option<Arc<Texture>>],
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

    /// The material of a name, which may follow later; notes a missing one.
    pub(super) fn material(&mut self, name: Word<'a>) -> Option<MaterialId> {
        let index = self.references.find(Referred::Material, name)?;
        Some(MaterialId(index as u32))
    }

    /// The image of a texture; `None` if it could not be loaded, which was reported.
    pub(super) fn image(&self, texture: TextureId) -> Option<&Texture> {
        self.textures.get(texture.0 as usize)?.as_deref()
    }
}
