//! Triangles.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};

use glam::{DMat4, DVec3};

/// Triangles. Normals and texture coordinates belong to vertices, and are empty if there are none.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mesh {
    pub(crate) name: String,
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) normals: Vec<[f32; 3]>,
    pub(crate) uvs: Vec<[f32; 2]>,
    pub(crate) faces: Vec<[u32; 3]>,
    /// Faces with more corners, which slo-rt itself divides.
    pub(crate) polygons: Vec<Vec<u32>>,
}

/// Finds meshes that there are already: files draw the same thing again and again.
#[derive(Debug, Default)]
pub(crate) struct KnownMeshes(HashMap<u64, Vec<usize>>);

impl KnownMeshes {
    /// The number of this mesh.
    pub(crate) fn number(&mut self, mesh: Mesh, meshes: &mut Vec<Mesh>) -> usize {
        let same = self.0.entry(mesh.hash()).or_default();
        if let Some(&known) = same.iter().find(|&&known| meshes[known].is_same(&mesh)) {
            return known;
        }
        same.push(meshes.len());
        meshes.push(mesh);
        meshes.len() - 1
    }
}

impl Mesh {
    /// Whether any triangle has an area, by the rule by which slo-rt drops the others: in f64, of corners
    /// that have been rounded to f32.
    pub(super) fn has_area(&self) -> bool {
        let corner = |i: u32| DVec3::from(self.positions[i as usize].map(f64::from));
        let has_area = |a: u32, b: u32, c: u32| {
            let (x, y) = (corner(b) - corner(a), corner(c) - corner(a));
            x.cross(y).try_normalize().is_some()
        };
        let is_wide = |polygon: &Vec<u32>| {
            polygon[1..].windows(2).any(|pair| has_area(polygon[0], pair[0], pair[1]))
        };
        self.faces.iter().any(|&[a, b, c]| has_area(a, b, c)) || self.polygons.iter().any(is_wide)
    }

    /// Number of triangles.
    pub(crate) fn triangles(&self) -> usize {
        self.faces.len() + self.polygons.iter().map(|polygon| polygon.len() - 2).sum::<usize>()
    }

    /// Whether the other has the same triangles.
    fn is_same(&self, other: &Self) -> bool {
        self.faces == other.faces
            && self.polygons == other.polygons
            && self.positions == other.positions
            && self.normals == other.normals
            && self.uvs == other.uvs
    }

    /// Equal for equal meshes.
    fn hash(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        let points = self.positions.iter().chain(&self.normals).flatten();
        for number in points.chain(self.uvs.iter().flatten()) {
            // Zero has two signs.
            (number + 0.0).to_bits().hash(&mut hasher);
        }
        (&self.faces, &self.polygons).hash(&mut hasher);
        hasher.finish()
    }

    pub(super) fn each_point(&self, mut of: impl FnMut(DVec3)) {
        for &[x, y, z] in &self.positions {
            of(DVec3::new(x.into(), y.into(), z.into()));
        }
    }

    /// The mesh as a matrix places it. Faces turn round where it mirrors.
    pub(crate) fn transformed(&self, matrix: DMat4) -> Self {
        let place = |p: &[f32; 3]| {
            matrix.transform_point3(DVec3::from(p.map(f64::from))).as_vec3().to_array()
        };
        // The cofactors: the inverse transpose times the determinant, which also serves flat matrices.
        let (x, y, z) =
            (matrix.x_axis.truncate(), matrix.y_axis.truncate(), matrix.z_axis.truncate());
        let (a, b, c) = (y.cross(z), z.cross(x), x.cross(y));
        let sign = if a.dot(x) < 0.0 { -1.0 } else { 1.0 };
        let bend = |n: &[f32; 3]| {
            let [nx, ny, nz] = n.map(f64::from);
            ((a * nx + b * ny + c * nz) * sign).normalize_or_zero().as_vec3().to_array()
        };
        let face = |&[i, j, k]: &[u32; 3]| if sign < 0.0 { [i, k, j] } else { [i, j, k] };
        let turn = |polygon: &Vec<u32>| {
            let mut polygon = polygon.clone();
            if sign < 0.0 {
                polygon.reverse();
            }
            polygon
        };
        Self {
            name: self.name.clone(),
            positions: self.positions.iter().map(place).collect(),
            normals: self.normals.iter().map(bend).collect(),
            uvs: self.uvs.clone(),
            faces: self.faces.iter().map(face).collect(),
            polygons: self.polygons.iter().map(turn).collect(),
        }
    }
}
