//! `environment`

use super::lamp::{Lamp, WrittenLight};
use crate::attributes::schema::{color, number, word};
use crate::attributes::{Bound, Fields};
use crate::kinds::Keyword;
use crate::material::{Palette, TextureId};
use crate::shape::Shape;

/// Light from all around, from infinitely far away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Environment {
    /// What it shows.
    pub sky: Sky,
    /// Multiplies what it shows.
    pub strength: f32,
    /// Turns the image about z from +x toward +y, degrees.
    pub turn_deg: f32,
}

/// What an environment shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sky {
    /// The same radiance everywhere, W/(m² sr).
    Even([f32; 3]),
    /// An equirectangular image: the middle is +x, the top is +z.
    Image(TextureId),
}

impl WrittenLight for Environment {
    const KEYWORDS: &'static [Keyword] = &[Keyword {
        keyword: "environment",
        attributes: &[
            color("radiance"),
            word("texture", "NAME"),
            number("strength"),
            number("turn_deg"),
        ],
    }];

    fn read<'a>(fields: &mut Fields<'_, 'a, '_>, palette: &mut Palette<'_, 'a>) -> Option<Self> {
        let radiance = fields.color("radiance").map(Sky::Even);
        let strength = fields.number_f32("strength", Bound::NotNegative).unwrap_or(1.0);
        let turn_deg = fields.number_f32("turn_deg", Bound::Any).unwrap_or(0.0);
        let image = match fields.word("texture") {
            Some(name) => Some(Sky::Image(palette.texture(name)?)),
            None => None,
        };
        Some(Self { sky: image.or(radiance)?, strength, turn_deg })
    }
}

impl Lamp for Environment {
    fn is_dark(&self) -> bool {
        self.strength == 0.0 || self.sky == Sky::Even([0.0; 3])
    }

    fn surface(&self) -> Option<Shape> {
        None
    }
}
