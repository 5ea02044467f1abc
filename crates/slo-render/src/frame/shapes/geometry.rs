//! Geometry of a shape.

use std::fmt;
use std::sync::Arc;

use glam::{DVec3, Vec3};

use crate::frame::sampled_motion::ObjectBox;
use slo_accel::Curved;
use slo_accel::curved::Part;
use slo_scene::Mesh;
use slo_scene::animation::DAffine;

/// Geometry of a shape, in object space.
#[derive(Debug)]
pub(in crate::frame) enum Geometry {
    /// Triangles, and whether their vertex normals are interpolated.
    Mesh(Arc<Mesh>, bool),
    /// One curved surface.
    Curved(Box<dyn CurvedSurface>),
}

/// A surface that is a single primitive for structures, in object space.
pub(in crate::frame) trait CurvedSurface: fmt::Debug + Send + Sync {
    /// Returns the primitive of the object transformed by `place`, which grows by the same factor in
    /// all directions.
    fn primitive(&self, place: &DAffine) -> Curved;

    /// Returns a bounding box of the surface.
    fn bounds(&self) -> ObjectBox;

    /// Returns the centre of the base and the vector to the tip: for a sphere, its centre and z.
    fn axis(&self) -> [DVec3; 2];

    /// Returns uv at a point of the surface.
    ///
    /// u runs once around the axis (z for a sphere), starting at x if the axis is z. v runs from
    /// the lower pole or the base to the upper pole or the tip. A disc shows the image's inscribed
    /// circle.
    fn uv_at(&self, point: Vec3, part: Part) -> [f32; 2];
}
