//! `lamp_sun`

use glam::DVec3;

use super::lamp::{CAMERA_VISIBLE, LIGHT_GROUP, Lamp, MOTION, REPEAT, WrittenLight};
use crate::attributes::schema::{color, number, point};
use crate::attributes::{Bound, Fields};
use crate::kinds::Keyword;
use crate::material::Palette;
use crate::shape::Shape;

/// Parallel light from a disc of the sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunLamp {
    /// What falls on a surface that faces the sun, W/m².
    pub irradiance: [f32; 3],
    /// Unit direction in which the light travels.
    pub direction: DVec3,
    /// Angle that the disc spans, degrees; 0: a point.
    pub angle_deg: f32,
}

impl WrittenLight for SunLamp {
    const KEYWORDS: &'static [Keyword] = &[Keyword {
        keyword: "lamp_sun",
        attributes: &[
            color("irradiance").required(),
            point("direction").required(),
            number("angle_deg"),
            CAMERA_VISIBLE,
            LIGHT_GROUP,
            MOTION,
            REPEAT,
        ],
    }];

    fn read<'a>(fields: &mut Fields<'_, 'a, '_>, _: &mut Palette<'_, 'a>) -> Option<Self> {
        let irradiance = fields.light("irradiance");
        let direction = fields.direction("direction");
        let angle_deg = fields.number_to("angle_deg", Bound::NotNegative, 180.0).unwrap_or(0.53);
        let direction = direction?.value.normalize();
        Some(Self { irradiance: irradiance?.value, direction, angle_deg })
    }
}

impl Lamp for SunLamp {
    fn is_dark(&self) -> bool {
        self.irradiance == [0.0; 3]
    }

    fn surface(&self) -> Option<Shape> {
        None
    }
}
