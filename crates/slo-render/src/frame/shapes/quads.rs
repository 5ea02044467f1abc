//! Flat shapes made of rectangles.

use std::sync::Arc;

use glam::DVec3;

use super::geometry::Geometry;
use slo_scene::Mesh;

/// A rectangle, given by its four corners in order. uv runs from (0, 0) at the first corner along
/// the second to (1, 1) at the third.
pub(super) type Quad = [DVec3; 4];

/// Makes a flat mesh of rectangles.
pub(super) fn flat(quads: &[Quad]) -> Geometry {
    let mut mesh =
        Mesh { uvs: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], ..Mesh::default() };
    for quad in quads {
        let base = mesh.positions.len() as u32;
        mesh.positions.extend(quad);
        for corners in [[0, 1, 2], [0, 2, 3]] {
            mesh.faces.push(corners.map(|c| base + c));
            mesh.face_uvs.push(corners);
        }
    }
    Geometry::Mesh(Arc::new(mesh), false)
}
