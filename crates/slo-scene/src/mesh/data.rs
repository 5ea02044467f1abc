//! Meshes as plain data.

use glam::DVec3;

use super::tangent::Tangent;

/// Triangles with shared vertices.
///
/// `positions` are in the file's units times `Scaling`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// One per vertex.
    pub positions: Vec<DVec3>,
    /// Vertex indices, counter-clockwise seen from outside; no degenerate triangle is left.
    pub faces: Vec<[u32; 3]>,
    /// Unit, one per vertex; empty if the mesh is not smooth.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates; v grows upwards in the image. Empty: the mesh has none.
    pub uvs: Vec<[f32; 2]>,
    /// Indices into `uvs`, one triple per face; empty if `uvs` is.
    pub face_uvs: Vec<[u32; 3]>,
    /// One triple per face: along which direction u grows at its corners; empty unless an image bends
    /// the normals of the mesh ([`add_tangents`](Self::add_tangents)).
    pub tangents: Vec<[Tangent; 3]>,
}

impl Mesh {
    /// Whether all indices lead to vertices and texture coordinates; a `smooth` mesh also needs a normal
    /// for each vertex.
    pub(crate) fn is_consistent(&self, smooth: bool) -> bool {
        let below = |faces: &[[u32; 3]], len: usize| {
            faces.iter().flatten().all(|&index| (index as usize) < len)
        };
        let has_normals = self.normals.len() == self.positions.len();
        below(&self.faces, self.positions.len())
            && (has_normals || (self.normals.is_empty() && !smooth))
            && below(&self.face_uvs, self.uvs.len())
            && (self.face_uvs.is_empty() || self.face_uvs.len() == self.faces.len())
            && (self.tangents.is_empty() || self.tangents.len() == self.faces.len())
    }
}

/// A mesh that can be rendered, and what is odd about its file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadedMesh {
    /// The triangles.
    pub mesh: Mesh,
    /// What was corrected, one line each.
    pub warnings: Vec<String>,
}
