//! Several files that make one mesh.

use super::normals::vertex_normals;
use crate::format::FileError;
use crate::mesh::data::Mesh;

impl Mesh {
    /// Adds the triangles of another mesh, with vertices, normals and uvs of their own.
    ///
    /// If only one of the two has uvs, all corners of the other get uv (0, 0); if only one
    /// has normals, the normals of the other are computed. The sum has no tangents.
    ///
    /// # Errors
    /// The sum has more vertices, uvs or triangles than 32-bit indices can count; `self` is then
    /// as it was.
    pub fn append(&mut self, mut other: Self) -> Result<(), FileError> {
        if self.faces.is_empty() && self.positions.is_empty() {
            *self = other;
            return Ok(());
        }
        check_count("vertices", self.positions.len(), other.positions.len())?;
        check_count("triangles", self.faces.len(), other.faces.len())?;
        check_count("uvs", self.uvs.len() + 1, other.uvs.len() + 1)?;
        if self.uvs.is_empty() != other.uvs.is_empty() {
            self.fill_uvs();
            other.fill_uvs();
        }
        if self.normals.is_empty() != other.normals.is_empty() {
            self.fill_normals();
            other.fill_normals();
        }
        let first_vertex = self.positions.len() as u32;
        let first_uv = self.uvs.len() as u32;
        self.tangents = Vec::new();
        self.positions.append(&mut other.positions);
        self.normals.append(&mut other.normals);
        self.uvs.append(&mut other.uvs);
        self.faces.extend(other.faces.iter().map(|face| face.map(|i| i + first_vertex)));
        self.face_uvs.extend(other.face_uvs.iter().map(|face| face.map(|i| i + first_uv)));
        Ok(())
    }

    /// Gives every corner uv (0, 0) if the mesh has no uvs.
    fn fill_uvs(&mut self) {
        if self.uvs.is_empty() {
            self.uvs.push([0.0; 2]);
            self.face_uvs = vec![[0; 3]; self.faces.len()];
        }
    }

    /// Computes normals if the mesh has none.
    fn fill_normals(&mut self) {
        if self.normals.is_empty() {
            self.normals = vertex_normals(&self.positions, &self.faces);
        }
    }
}

/// Whether two counts add up to something that a 32-bit index reaches.
fn check_count(what: &str, a: usize, b: usize) -> Result<(), FileError> {
    if a + b <= u32::MAX as usize {
        return Ok(());
    }
    Err(FileError::whole_file(format!("the mesh has {} {what}, more than {}", a + b, u32::MAX)))
}
