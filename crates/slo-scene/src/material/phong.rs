//! `material_phong`, `material_texture`: the thesis's lighting model.

use super::SHARP;
use super::look::{Look, WrittenMaterial};
use super::palette::Palette;
use super::phong_info::PhongInfo;
use super::texture::{TextureId, TextureUse};
use crate::attributes::schema::{number, word};
use crate::attributes::{Bound, Fields};
use crate::kinds::Keyword;

/// The thesis's lighting model, with an image.
#[derive(Clone, Debug)]
pub struct Phong {
    /// The `phong_info` that the material refers to.
    pub info: PhongInfo,
    /// Multiplies ambient and diffuse.
    pub texture: Option<TextureUse>,
}

impl WrittenMaterial for Phong {
    const KEYWORDS: &'static [Keyword] = &[
        Keyword { keyword: "material_phong", attributes: &[word("phong_info", "NAME").required()] },
        Keyword {
            keyword: "material_texture",
            attributes: &[
                word("phong_info", "NAME").required(),
                word("texture", "NAME").required(),
                number("scale_U"),
                number("scale_V"),
            ],
        },
    ];

    fn read<'a>(fields: &mut Fields<'_, 'a, '_>, palette: &mut Palette<'_, 'a>) -> Option<Self> {
        let (phong, texture) = (fields.word("phong_info"), fields.word("texture"));
        let scale =
            ["scale_U", "scale_V"].map(|name| fields.number_f32(name, Bound::Any).unwrap_or(1.0));
        let info = phong.and_then(|name| palette.phong_info(name).cloned());
        let texture = texture.and_then(|name| palette.texture(name));
        let texture = texture.map(|texture| TextureUse { texture, scale });
        Some(Self { info: info?, texture })
    }
}

impl Look for Phong {
    fn glows(&self) -> bool {
        self.info.ambient != [0.0; 3]
    }

    fn is_sharp(&self) -> bool {
        // A lobe cos^n is as wide as microfacets with alpha² = 2 / (n + 2), and n is 1 / spread².
        let is_narrow =
            |spread: f32| 2.0 * spread * spread < SHARP * SHARP * (1.0 + spread * spread);
        let PhongInfo { reflectance, diffuse_reflection, refraction, diffuse_refraction, .. } =
            self.info;
        (reflectance > 0.0 && is_narrow(diffuse_reflection))
            || (refraction > 0.0 && is_narrow(diffuse_refraction))
    }

    fn for_images(&self, put: &mut dyn FnMut(TextureId)) {
        self.texture.iter().for_each(|of| put(of.texture));
    }
}
