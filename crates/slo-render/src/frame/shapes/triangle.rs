//! `triangle`

use std::sync::Arc;

use super::geometry::Geometry;
use slo_scene::Mesh;
use slo_scene::shape::Triangle;

/// Returns a mesh of one face. uv runs from (0, 0) at the first corner along the second to (1, 1)
/// at the third.
pub(super) fn geometry(shape: &Triangle) -> Geometry {
    let mesh = Mesh {
        positions: shape.vertices.to_vec(),
        faces: vec![[0, 1, 2]],
        uvs: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]],
        face_uvs: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    Geometry::Mesh(Arc::new(mesh), false)
}
