//! `lamp_spot`

use glam::DVec3;

use super::lamp::{Lamp, WrittenLight};
use crate::attributes::schema::{color, number, point};
use crate::attributes::{Bound, Fields};
use crate::kinds::Keyword;
use crate::material::Palette;
use crate::shape::{Shape, Sphere};

/// A lamp that shines into a cone: a point, or a sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpotLamp {
    /// What leaves the cone if its rim is sharp, W.
    pub power: [f32; 3],
    /// Centre.
    pub position: DVec3,
    /// Of the sphere; 0: a point.
    pub radius: f64,
    /// Unit direction of the middle of the cone.
    pub axis: DVec3,
    /// Of the whole cone, degrees; more than 0, 180 at most.
    pub angle_deg: f32,
    /// Share of the cone in which the light fades toward the rim, from 0 to 1.
    pub blend: f32,
}

impl WrittenLight for SpotLamp {
    const KEYWORDS: &'static [Keyword] = &[Keyword {
        keyword: "lamp_spot",
        attributes: &[
            color("power").required(),
            point("position").required(),
            number("radius"),
            point("target").required(),
            number("angle_deg").required(),
            number("blend"),
        ],
    }];

    fn read<'a>(fields: &mut Fields<'_, 'a, '_>, _: &mut Palette<'_, 'a>) -> Option<Self> {
        let power = fields.color("power");
        let position = fields.point("position");
        let radius = fields.length("radius", Bound::NotNegative).map_or(0.0, |r| r.value);
        let target = fields.point("target");
        let angle_deg = fields.number_f32("angle_deg", Bound::Positive);
        let blend = fields.number_f32("blend", Bound::NotNegative).unwrap_or(0.0);
        let (position, target) = (position?.value, target?.value);
        let axis = (target - position).normalize_or(DVec3::NEG_Z);
        Some(Self { power: power?, position, radius, axis, angle_deg: angle_deg?, blend })
    }
}

impl Lamp for SpotLamp {
    fn is_dark(&self) -> bool {
        self.power == [0.0; 3]
    }

    fn surface(&self) -> Option<Shape> {
        let sphere = Sphere { center: self.position, radius: self.radius };
        (self.radius > 0.0).then_some(Shape::Sphere(sphere))
    }
}
