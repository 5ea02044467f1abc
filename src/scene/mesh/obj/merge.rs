//! From corners with indices of their own for everything to vertices with normals.

use std::collections::HashMap;

use glam::DVec3;

use super::lines::Parts;
use crate::format::FileError;
use crate::scene::Mesh;
use crate::scene::mesh::normals::unit;

/// The mesh of a file that `tobj` has read; `parts` has an entry for each triangle.
///
/// # Errors
/// Splitting makes more vertices than 32-bit indices can count.
pub(super) fn merge(file: tobj::Mesh, parts: &[Parts], smooth: bool) -> Result<Mesh, FileError> {
    let mut mesh = Mesh {
        positions: file.positions.chunks_exact(3).map(DVec3::from_slice).collect(),
        faces: triples(&file.indices).collect(),
        ..Mesh::default()
    };
    if parts.iter().any(|part| part.uvs) {
        add_uvs(&mut mesh, &file, parts);
    }
    if smooth && parts.iter().any(|part| part.normals) {
        let mut split = Split::new(&mut mesh);
        for (face, (normals, part)) in triples(&file.normal_indices).zip(parts).enumerate() {
            let normals = normals.map(|n| if part.normals { normal(&file, n) } else { [0.0; 3] });
            split.face(face, normals)?;
        }
    }
    Ok(mesh)
}

/// Indices, three by three.
fn triples(indices: &[u32]) -> impl Iterator<Item = [u32; 3]> + '_ {
    indices.chunks_exact(3).map(|triple| [triple[0], triple[1], triple[2]])
}

/// Keeps the uvs of the file; triangles without get uv (0, 0).
fn add_uvs(mesh: &mut Mesh, file: &tobj::Mesh, parts: &[Parts]) {
    mesh.uvs = file.texcoords.chunks_exact(2).map(|uv| [uv[0] as f32, uv[1] as f32]).collect();
    if parts.iter().any(|part| !part.uvs) {
        mesh.uvs.push([0.0; 2]);
    }
    let none = (mesh.uvs.len() - 1) as u32;
    let uvs = triples(&file.texcoord_indices).zip(parts);
    mesh.face_uvs = uvs.map(|(uvs, part)| if part.uvs { uvs } else { [none; 3] }).collect();
}

/// A normal of the file with length 1; zero where it has no direction.
fn normal(file: &tobj::Mesh, index: u32) -> [f32; 3] {
    let start = 3 * index as usize;
    let direction = file.normals.get(start..start + 3).map(DVec3::from_slice);
    direction.and_then(unit).unwrap_or_default()
}

/// Vertices, each with one normal; those that need a second one are doubled.
struct Split<'m> {
    mesh: &'m mut Mesh,
    /// Whether a vertex has its normal.
    settled: Vec<bool>,
    /// The doubles: which vertex with which normal, as bits.
    doubles: HashMap<(u32, [u32; 3]), u32>,
}

impl<'m> Split<'m> {
    /// No vertex has a normal yet.
    fn new(mesh: &'m mut Mesh) -> Self {
        let vertices = mesh.positions.len();
        mesh.normals = vec![[0.0; 3]; vertices];
        Self { mesh, settled: vec![false; vertices], doubles: HashMap::new() }
    }

    /// Gives the corners of a face their normals.
    fn face(&mut self, face: usize, normals: [[f32; 3]; 3]) -> Result<(), FileError> {
        let mut corners = self.mesh.faces[face];
        for (corner, normal) in corners.iter_mut().zip(normals) {
            *corner = self.corner(*corner, normal)?;
        }
        self.mesh.faces[face] = corners;
        Ok(())
    }

    /// The vertex at the place of `vertex` that has that normal.
    fn corner(&mut self, vertex: u32, normal: [f32; 3]) -> Result<u32, FileError> {
        let index = vertex as usize;
        if !self.settled[index] {
            self.settled[index] = true;
            self.mesh.normals[index] = normal;
        }
        if self.mesh.normals[index] == normal {
            return Ok(vertex);
        }
        let key = (vertex, normal.map(f32::to_bits));
        if let Some(&double) = self.doubles.get(&key) {
            return Ok(double);
        }
        let double = u32::try_from(self.mesh.positions.len())
            .ok()
            .filter(|&double| double < u32::MAX)
            .ok_or_else(|| FileError::whole_file("the mesh has too many vertices"))?;
        self.mesh.positions.push(self.mesh.positions[index]);
        self.mesh.normals.push(normal);
        self.doubles.insert(key, double);
        Ok(double)
    }
}
