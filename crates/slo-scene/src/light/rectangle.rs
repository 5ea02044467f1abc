//! `light_rectangle`

use super::lamp::{Lamp, MOTION, REPEAT, WrittenLight};
use crate::attributes::schema::{color, point};
use crate::attributes::{Fields, PARENT};
use crate::kinds::Keyword;
use crate::material::Palette;
use crate::shape::{Rectangle, Shape};

/// A rectangle that shines on both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RectangleLight {
    /// Radiance that reaches a hit from all of it, at any distance.
    pub color: [f32; 3],
    /// The surface, in lamp space.
    pub rectangle: Rectangle,
}

impl WrittenLight for RectangleLight {
    const KEYWORDS: &'static [Keyword] = &[Keyword {
        keyword: "light_rectangle",
        attributes: &[
            color("color").required(),
            point("vertex0").required(),
            point("vertex1").required(),
            point("vertex2").required(),
            PARENT,
            MOTION,
            REPEAT,
        ],
    }];

    fn read<'a>(fields: &mut Fields<'_, 'a, '_>, _: &mut Palette<'_, 'a>) -> Option<Self> {
        let color = fields.color("color");
        let rectangle = Rectangle::of_corners(fields);
        Some(Self { color: color?, rectangle: rectangle? })
    }
}

impl Lamp for RectangleLight {
    fn is_dark(&self) -> bool {
        self.color == [0.0; 3]
    }

    fn surface(&self) -> Option<Shape> {
        Some(Shape::Rectangle(self.rectangle))
    }
}
