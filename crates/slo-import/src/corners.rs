//! Meshes from corners that share positions, normals and texture coordinates as they like.

use std::collections::HashMap;

use crate::model::Mesh;

/// Numbers of a position, a normal and a texture coordinate.
pub(crate) type Corner = (u32, Option<u32>, Option<u32>);

/// Builds a mesh in which each vertex has one normal and one texture coordinate.
#[derive(Debug, Default)]
pub(crate) struct Corners {
    vertices: HashMap<Corner, u32>,
    order: Vec<Corner>,
    faces: Vec<[u32; 3]>,
    polygons: Vec<Vec<u32>>,
}

impl Corners {
    /// Adds a face of three corners or more.
    pub(crate) fn add(&mut self, face: &[Corner]) {
        let Self { vertices, order, .. } = self;
        let vertex = |corner: &Corner| {
            *vertices.entry(*corner).or_insert_with(|| {
                order.push(*corner);
                order.len() as u32 - 1
            })
        };
        let face: Vec<u32> = face.iter().map(vertex).collect();
        match face[..] {
            [a, b, c] => self.faces.push([a, b, c]),
            _ => self.polygons.push(face),
        }
    }

    /// Whether there is no face.
    pub(crate) fn is_empty(&self) -> bool {
        self.faces.is_empty() && self.polygons.is_empty()
    }

    /// The mesh. It has normals if all corners do, and texture coordinates if any does.
    pub(crate) fn mesh(
        self,
        name: String,
        positions: &[[f32; 3]],
        normals: &[[f32; 3]],
        uvs: &[[f32; 2]],
    ) -> Mesh {
        let Self { order, faces, polygons, .. } = self;
        let column = |of: fn(&Corner) -> Option<u32>| order.iter().map(of);
        let normals = column(|corner| corner.1).map(|n| n.map(|n| normals[n as usize]));
        let normals: Option<Vec<[f32; 3]>> = normals.collect();
        let has_uvs = column(|corner| corner.2).any(|uv| uv.is_some());
        let uvs = column(|corner| corner.2).map(|uv| uv.map_or([0.0; 2], |uv| uvs[uv as usize]));
        Mesh {
            name,
            positions: order.iter().map(|corner| positions[corner.0 as usize]).collect(),
            normals: normals.unwrap_or_default(),
            uvs: if has_uvs { uvs.collect() } else { Vec::new() },
            faces,
            polygons,
        }
    }
}
