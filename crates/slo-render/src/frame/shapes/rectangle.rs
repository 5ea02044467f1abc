//! `rectangle`

use super::geometry::Geometry;
use super::quads::flat;
use slo_scene::shape::Rectangle;

pub(super) fn geometry(shape: &Rectangle) -> Geometry {
    flat(&[shape.corners()])
}
