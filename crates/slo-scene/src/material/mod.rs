//! Materials: one file for each kind, with its data, its elements of the language, and how they are
//! read.

mod contained;
mod id;
mod inputs;
mod look;
mod mix;
mod palette;
mod phong;
mod phong_info;
mod principled;
mod texture;
mod varying;
mod written_image;

use crate::attributes::Fields;
use crate::kinds::kinds;
use look::{Look, WrittenMaterial};

pub use contained::{MOST_MIXES, Tangle, inside_out};
pub use id::MaterialId;
pub use mix::Mix;
pub use phong::Phong;
pub use phong_info::PhongInfo;
pub use principled::Principled;
pub use texture::{Channel, ImageUse, TextureId, TextureUse};
pub use varying::Varying;

pub(crate) use contained::{Whole, check_contained, wholes};
pub(crate) use palette::Palette;
pub(crate) use phong_info::{PHONG_INFO, phong_info};

/// Width alpha of microfacets, the square of the roughness, below which photons follow what a
/// surface reflects or refracts, and above which they end there.
pub const SHARP: f32 = 0.2;

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
    #[allow(clippy::large_enum_variant, reason = "a scene has few materials")]
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
    /// Whether a surface can be seen without light on it, apart from what it contains.
    pub(crate) fn glows(&self) -> bool {
        self.common().glows()
    }

    /// Whether photons follow what a surface reflects or refracts, apart from what it contains.
    pub fn is_sharp(&self) -> bool {
        self.common().is_sharp()
    }

    /// Whether an image bends its normals, apart from what it contains.
    pub(crate) fn bends_normals(&self) -> bool {
        self.common().bends_normals()
    }

    /// Hands each image that the material uses itself to `put`; one may come several times.
    pub fn for_images(&self, put: &mut dyn FnMut(TextureId)) {
        self.common().for_images(put);
    }

    /// The materials that it mixes.
    pub fn parts(&self) -> Option<[MaterialId; 2]> {
        self.common().parts()
    }
}
