//! Materials: one file for each kind, with its data, its elements of the language, and how they are
//! read.

mod look;
mod mix;
mod palette;
mod phong;
mod phong_info;
mod principled;
mod texture;

use crate::attributes::Fields;
use crate::kinds::kinds;
use look::{Look, WrittenMaterial};

pub use mix::Mix;
pub use phong::Phong;
pub use phong_info::PhongInfo;
pub use principled::{Principled, Varying};
pub use texture::{Channel, ImageUse, TextureId, TextureUse};

pub(crate) use palette::Palette;
pub(crate) use phong_info::{PHONG_INFO, phong_info};

/// How an element becomes a material.
pub(crate) type ReadMaterial =
    for<'a> fn(&mut Fields<'_, 'a, '_>, &mut Palette<'_, 'a>) -> Option<MaterialKind>;

/// A material.
#[derive(Clone, Debug)]
pub struct Material {
    /// The name in the text.
    pub name: String,
    /// What it does to light.
    pub kind: MaterialKind,
}

kinds! {
    /// What a material does to light.
    pub enum MaterialKind: dyn Look, read by ReadMaterial {
        /// `material_phong`, `material_texture`
        Phong(Phong),
        /// `material_principled`
        Principled(Principled),
        /// `material_mix`
        Mix(Mix),
    }
}

impl MaterialKind {
    /// Whether a surface can be seen without light on it.
    pub(crate) fn glows(&self) -> bool {
        self.common().glows()
    }

    /// The image that it shows, if any.
    pub(crate) fn image(&self) -> Option<TextureId> {
        self.common().image()
    }
}
