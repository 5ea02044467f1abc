//! `lamp_point`

use glam::DVec3;

use super::lamp::{
    CAMERA_VISIBLE, LIGHT_GROUP, Lamp, MOTION, REPEAT, SOLID, WrittenLight, radius_or_point,
};
use crate::attributes::Fields;
use crate::attributes::schema::{color, number, point};
use crate::kinds::Keyword;
use crate::material::Palette;
use crate::shape::{Shape, Sphere};

/// A lamp that shines all round: a point, or a sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLamp {
    /// All that it sends out, W.
    pub power: [f32; 3],
    /// Centre.
    pub position: DVec3,
    /// Of the sphere; 0: a point.
    pub radius: f64,
}

impl WrittenLight for PointLamp {
    const KEYWORDS: &'static [Keyword] = &[Keyword {
        keyword: "lamp_point",
        attributes: &[
            color("power").required(),
            point("position").required(),
            number("radius"),
            CAMERA_VISIBLE,
            SOLID,
            LIGHT_GROUP,
            MOTION,
            REPEAT,
        ],
    }];

    fn read<'a>(fields: &mut Fields<'_, 'a, '_>, _: &mut Palette<'_, 'a>) -> Option<Self> {
        let power = fields.light("power");
        let position = fields.point("position");
        let radius = radius_or_point(fields);
        Some(Self { power: power?.value, position: position?.value, radius: radius? })
    }
}

impl Lamp for PointLamp {
    fn is_dark(&self) -> bool {
        self.power == [0.0; 3]
    }

    fn surface(&self) -> Option<Shape> {
        let sphere = Sphere { center: self.position, radius: self.radius };
        (self.radius > 0.0).then_some(Shape::Sphere(sphere))
    }
}
