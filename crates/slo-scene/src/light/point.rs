//! `light_point`

use glam::DVec3;

use super::lamp::{Lamp, MOTION, REPEAT, WrittenLight};
use crate::attributes::schema::{color, point};
use crate::attributes::{Fields, PARENT};
use crate::kinds::Keyword;
use crate::material::Palette;
use crate::shape::Shape;

/// A light without a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLight {
    /// Radiance that reaches a hit, at any distance.
    pub color: [f32; 3],
    /// Position, in lamp space.
    pub position: DVec3,
}

impl WrittenLight for PointLight {
    const KEYWORDS: &'static [Keyword] = &[Keyword {
        keyword: "light_point",
        attributes: &[
            color("color").required(),
            point("position").required(),
            PARENT,
            MOTION,
            REPEAT,
        ],
    }];

    fn read<'a>(fields: &mut Fields<'_, 'a, '_>, _: &mut Palette<'_, 'a>) -> Option<Self> {
        let color = fields.color("color");
        let position = fields.point("position");
        Some(Self { color: color?, position: position?.value })
    }
}

impl Lamp for PointLight {
    fn is_dark(&self) -> bool {
        self.color == [0.0; 3]
    }

    fn surface(&self) -> Option<Shape> {
        None
    }
}
