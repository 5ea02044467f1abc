//! Converts shapes to primitives, one file for each shape. Flat shapes become small meshes; curved
//! shapes remain single primitives.

mod cone;
mod cuboid;
mod cylinder;
mod disc;
mod geometry;
mod plane;
mod quads;
mod rectangle;
mod round;
mod sphere;
mod triangle;

use std::sync::Arc;

use slo_scene::{LightKind, Shape};

pub(super) use geometry::Geometry;
pub(super) use round::tangent_about;

/// Returns the geometry of a shape.
pub(super) fn geometry(shape: &Shape) -> Geometry {
    match shape {
        Shape::Plane(shape) => plane::geometry(shape),
        Shape::Sphere(shape) => Geometry::Curved(Box::new(*shape)),
        Shape::Triangle(shape) => triangle::geometry(shape),
        Shape::Rectangle(shape) => rectangle::geometry(shape),
        Shape::Box(shape) => cuboid::geometry(shape),
        Shape::Cylinder(shape) => Geometry::Curved(Box::new(*shape)),
        Shape::Cone(shape) => Geometry::Curved(Box::new(*shape)),
        Shape::Mesh(surface) => Geometry::Mesh(Arc::clone(&surface.mesh), surface.smooth),
    }
}

/// Returns the geometry of the surface that shines; `None` if no ray can hit the light.
pub(super) fn lamp_geometry(light: &LightKind) -> Option<Geometry> {
    match light {
        LightKind::DiscLamp(lamp) => Some(Geometry::Curved(Box::new(*lamp))),
        _ => light.surface().as_ref().map(geometry),
    }
}
