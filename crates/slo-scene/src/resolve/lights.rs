//! Lights.

use glam::DVec3;

use super::fields::Fields;
use super::shapes::corners;
use crate::{Light, LightShape};

/// `light_point`
pub(super) fn point(fields: &mut Fields<'_, '_, '_>) -> Option<Light> {
    let color = fields.color("color");
    let position = fields.point("position");
    light(fields, color, LightShape::Point { position: position?.value })
}

/// `light_rectangle`
pub(super) fn rectangle(fields: &mut Fields<'_, '_, '_>) -> Option<Light> {
    let color = fields.color("color");
    let vertices: Option<[DVec3; 3]> = corners(fields, true);
    light(fields, color, LightShape::Rectangle { vertices: vertices? })
}

fn light(fields: &Fields<'_, '_, '_>, color: Option<[f32; 3]>, shape: LightShape) -> Option<Light> {
    Some(Light { name: fields.element.name.text.to_owned(), color: color?, shape })
}
