//! What a shape consists of.

use std::fmt;
use std::sync::Arc;

use glam::Vec3;

use crate::frame::sampled_motion::ObjectBox;
use slo_accel::Curved;
use slo_accel::curved::Part;
use slo_scene::Mesh;
use slo_scene::animation::DRigid;

/// What a shape consists of, in object space.
#[derive(Debug)]
pub(in crate::frame) enum Geometry {
    /// Triangles, and whether their vertex normals are interpolated.
    Mesh(Arc<Mesh>, bool),
    /// One curved surface.
    Curved(Box<dyn CurvedSurface>),
}

/// A surface that structures know as one primitive, in object space.
pub(in crate::frame) trait CurvedSurface: fmt::Debug + Send + Sync {
    /// The primitive where the object lies at a place.
    fn primitive(&self, place: &DRigid) -> Curved;

    /// A box about the surface.
    fn bounds(&self) -> ObjectBox;

    /// uv at a point of the surface.
    ///
    /// u runs once around the axis (z for a sphere), from x where the axis is z; v from the lower
    /// pole or the base to the upper pole or the tip. A disc shows the image's inscribed circle.
    fn uv_at(&self, point: Vec3, part: Part) -> [f32; 2];
}
