//! `material_mix`: two materials, mixed.

use super::id::MaterialId;
use super::look::{Look, WrittenMaterial};
use super::palette::Palette;
use super::texture::TextureId;
use super::varying::{Quantity, Varying, read_varying};
use super::written_image::IMAGE;
use crate::attributes::schema::{Schema, number, word, word_or_block};
use crate::attributes::{Bound, Fields};
use crate::kinds::Keyword;

/// Two materials, mixed.
#[derive(Clone, Debug, PartialEq)]
pub struct Mix {
    /// What is seen where the factor is 0.
    pub first: MaterialId,
    /// What is seen where the factor is 1.
    pub second: MaterialId,
    /// Share of the second material, from 0 to 1.
    pub factor: Varying<f32>,
}

/// The factor of a mix that names none.
const HALF: f32 = 0.5;

impl WrittenMaterial for Mix {
    const KEYWORDS: &'static [Keyword] = &[Keyword {
        keyword: "material_mix",
        attributes: &[
            word("first", "NAME").required().elsewhere(&["material1", "a", "base"]),
            word("second", "NAME").required().elsewhere(&["material2", "b", "top"]),
            number("factor").elsewhere(&["amount", "weight", "fac", "mix"]),
            word_or_block("NAME", &Schema::new("factor_texture", IMAGE)).elsewhere(&[
                "amount_texture",
                "weight_texture",
                "mask",
            ]),
        ],
    }];

    fn read<'a>(fields: &mut Fields<'_, 'a, '_>, palette: &mut Palette<'_, 'a>) -> Option<Self> {
        let names = ["factor", "factor_texture"];
        let range = (HALF, Bound::Share);
        let factor = read_varying(fields, palette, names, range, <f32 as Quantity>::PURPOSE);
        let parts = ["first", "second"].map(|name| fields.word(name));
        let [first, second] = parts.map(|name| name.and_then(|name| palette.material(name)));
        Some(Self { first: first?, second: second?, factor })
    }
}

impl Look for Mix {
    fn glows(&self) -> bool {
        false
    }

    fn for_images(&self, put: &mut dyn FnMut(TextureId)) {
        self.factor.texture().into_iter().for_each(put);
    }

    fn parts(&self) -> Option<[MaterialId; 2]> {
        Some([self.first, self.second])
    }
}
