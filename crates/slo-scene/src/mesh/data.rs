//! Meshes as plain data.

use glam::DVec3;

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
}

/// A mesh that can be rendered, and what is odd about its file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadedMesh {
    /// The triangles.
    pub mesh: Mesh,
    /// What was corrected, one line each.
    pub warnings: Vec<String>,
}
