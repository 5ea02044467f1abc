//! `lamp_spot`

use glam::DVec3;

use super::lamp::{
    CAMERA_VISIBLE, LIGHT_GROUP, Lamp, MOTION, REPEAT, SOLID, WrittenLight, radius_or_point,
};
use crate::attributes::schema::{color, number, point};
use crate::attributes::{Bound, Fields, Found};
use crate::diagnostics::Diagnostic;
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
        let target = fields.point("target");
        let angle_deg = fields.number_to("angle_deg", Bound::Positive, 180.0);
        let blend = fields.number_to("blend", Bound::NotNegative, 1.0).unwrap_or(0.0);
        let (position, target) = (position?, target?);
        let axis = axis(fields, position, target);
        Some(Self {
            power: power?.value,
            position: position.value,
            radius: radius?,
            axis: axis?,
            angle_deg: angle_deg?,
            blend,
        })
    }
}

/// The direction from the lamp to its target.
fn axis(
    fields: &mut Fields<'_, '_, '_>,
    position: Found<DVec3>,
    target: Found<DVec3>,
) -> Option<DVec3> {
    let axis = (target.value - position.value).try_normalize();
    if axis.is_none() {
        let message = format!("{} stands at its own target", fields.element.title());
        let error = Diagnostic::error(message).at(target.span, "the target");
        fields.diagnostics.push(error.also(position.span, "the position"));
    }
    axis
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
