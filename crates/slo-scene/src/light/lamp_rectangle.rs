//! `lamp_rectangle`

use super::lamp::{
    CAMERA_VISIBLE, LIGHT_GROUP, Lamp, MOTION, REPEAT, SOLID, WrittenLight, radiance_of,
};
use crate::attributes::Fields;
use crate::attributes::schema::{color, number, point};
use crate::kinds::Keyword;
use crate::material::Palette;
use crate::shape::{Rectangle, Shape};

/// A rectangle that glows evenly in all directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RectangleLamp {
    /// W/(m² sr)
    pub radiance: [f32; 3],
    /// The surface; its front is along (v1 - v0) x (v2 - v1).
    pub rectangle: Rectangle,
    /// Whether the back glows too.
    pub two_sided: bool,
}

impl WrittenLight for RectangleLamp {
    const KEYWORDS: &'static [Keyword] = &[Keyword {
        keyword: "lamp_rectangle",
        attributes: &[
            color("power"),
            color("radiance"),
            point("vertex0").required(),
            point("vertex1").required(),
            point("vertex2").required(),
            number("two_sided"),
            CAMERA_VISIBLE,
            SOLID,
            LIGHT_GROUP,
            MOTION,
            REPEAT,
        ],
    }];

    fn read<'a>(fields: &mut Fields<'_, 'a, '_>, _: &mut Palette<'_, 'a>) -> Option<Self> {
        let two_sided = fields.count("two_sided", 0, 1).is_some_and(|flag| flag.value == 1);
        let rectangle = Rectangle::of_corners(fields);
        // Without corners, the light itself is checked all the same.
        let area = rectangle.map_or(1.0, |rectangle| {
            let [v0, v1, v2] = rectangle.vertices;
            (v1 - v0).cross(v2 - v1).length()
        });
        let radiance = radiance_of(fields, if two_sided { 2.0 * area } else { area });
        Some(Self { radiance: radiance?, rectangle: rectangle?, two_sided })
    }
}

impl Lamp for RectangleLamp {
    fn is_dark(&self) -> bool {
        self.radiance == [0.0; 3]
    }

    fn surface(&self) -> Option<Shape> {
        Some(Shape::Rectangle(self.rectangle))
    }
}
