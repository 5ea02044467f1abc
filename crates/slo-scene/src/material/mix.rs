//! `material_mix`: two materials, mixed.

use super::look::{Look, WrittenMaterial};
use super::palette::Palette;
use super::principled::Varying;
use super::texture::TextureId;
use crate::attributes::schema::{number, word};
use crate::attributes::{Bound, Fields, Referred};
use crate::description::MaterialId;
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

impl WrittenMaterial for Mix {
    const KEYWORDS: &'static [Keyword] = &[Keyword {
        keyword: "material_mix",
        attributes: &[
            word("first", "NAME").required(),
            word("second", "NAME").required(),
            number("factor"),
        ],
    }];

    fn read<'a>(fields: &mut Fields<'_, 'a, '_>, palette: &mut Palette<'_, 'a>) -> Option<Self> {
        let (first, second) = (fields.word("first"), fields.word("second"));
        let factor = fields.number_f32("factor", Bound::NotNegative).unwrap_or(0.5);
        let mut find = |name| palette.references.find(Referred::Material, name);
        let first = first.and_then(&mut find).map(|index| MaterialId(index as u32));
        let second = second.and_then(&mut find).map(|index| MaterialId(index as u32));
        Some(Self { first: first?, second: second?, factor: Varying::constant(factor) })
    }
}

impl Look for Mix {
    fn glows(&self) -> bool {
        false
    }

    fn image(&self) -> Option<TextureId> {
        self.factor.image.map(|image| image.texture)
    }
}
