//! `environment`

use super::lamp::{CAMERA_VISIBLE, LIGHT_GROUP, Lamp, WrittenLight};
use crate::attributes::schema::{color, number, word};
use crate::attributes::{Bound, Fields};
use crate::diagnostics::Diagnostic;
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
            word("texture", "NAME"),
            color("radiance"),
            number("strength"),
            number("turn_deg"),
            CAMERA_VISIBLE,
            LIGHT_GROUP,
        ],
    }];

    fn read<'a>(fields: &mut Fields<'_, 'a, '_>, palette: &mut Palette<'_, 'a>) -> Option<Self> {
        let strength = fields.number_f32("strength", Bound::NotNegative).unwrap_or(1.0);
        let turn_deg = fields.number_f32("turn_deg", Bound::Any).unwrap_or(0.0);
        let sky = match fields.either(["radiance", "texture"])? {
            "texture" => Sky::Image(palette.texture(fields.word("texture")?)?),
            _ => {
                warn_of_turn(fields);
                Sky::Even(fields.color("radiance")?)
            }
        };
        Some(Self { sky, strength, turn_deg })
    }
}

/// Warns of a turn of what looks the same everywhere.
fn warn_of_turn(fields: &mut Fields<'_, '_, '_>) {
    if let Some(field) = fields.get("turn_deg") {
        let warning = Diagnostic::warning("`turn_deg` has no effect without `texture`");
        fields.diagnostics.push(warning.at(field.keyword.span, ""));
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
