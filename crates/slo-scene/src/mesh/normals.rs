//! Normals of triangles and vertices.

use std::collections::BTreeSet;

use glam::DVec3;

use super::data::Mesh;

/// The unit normal of a counter-clockwise triangle; `None` if its area is zero in f64.
pub(super) fn triangle_normal([a, b, c]: [DVec3; 3]) -> Option<DVec3> {
    (b - a).cross(c - a).try_normalize()
}

/// Corners of a face. Its indices must lie within `positions`.
pub(super) fn corners(positions: &[DVec3], face: [u32; 3]) -> [DVec3; 3] {
    face.map(|i| positions[i as usize])
}

/// A unit normal for each vertex: the normalised sum of the unit normals of its triangles, every
/// triangle with the same weight, however large it is.
///
/// Where the sum is zero (two sides of a sheet that share their vertices) the last triangle of
/// the vertex decides; a vertex of no triangle gets +z.
///
/// Source: slo-RT thesis, chapter on meshes: the normalised sum of the normals of the triangles.
pub(super) fn vertex_normals(positions: &[DVec3], faces: &[[u32; 3]]) -> Vec<[f32; 3]> {
    let mut sums = vec![DVec3::ZERO; positions.len()];
    add_face_normals(positions, faces, |vertex, normal| sums[vertex] += normal);
    let mut normals: Vec<_> = sums.iter().map(|&sum| unit(sum).unwrap_or([0.0; 3])).collect();
    if normals.contains(&[0.0; 3]) {
        add_face_normals(positions, faces, |vertex, normal| {
            if sums[vertex].try_normalize().is_none() {
                normals[vertex] = normal.as_vec3().to_array();
            }
        });
    }
    for normal in normals.iter_mut().filter(|normal| **normal == [0.0; 3]) {
        *normal = [0.0, 0.0, 1.0];
    }
    normals
}

impl Mesh {
    /// Computes the normals anew of all vertices of faces that hold a vertex that was moved. A mesh
    /// without normals stays without.
    pub fn renew_normals(&mut self, moved: &BTreeSet<u32>) {
        if self.normals.is_empty() {
            return;
        }
        let holds = |face: &&[u32; 3]| face.iter().any(|vertex| moved.contains(vertex));
        let touched: BTreeSet<u32> = self.faces.iter().filter(holds).flatten().copied().collect();
        let is_near = |face: &[u32; 3]| face.iter().any(|vertex| touched.contains(vertex));
        let near: Vec<[u32; 3]> = self.faces.iter().copied().filter(is_near).collect();
        // Few faces, many vertices: those of the faces get numbers of their own.
        let vertices: Vec<u32> =
            near.iter().flatten().copied().collect::<BTreeSet<_>>().into_iter().collect();
        let place = |vertex: u32| vertices.binary_search(&vertex).unwrap_or_default() as u32;
        let positions: Vec<DVec3> =
            vertices.iter().map(|&vertex| self.positions[vertex as usize]).collect();
        let faces: Vec<[u32; 3]> = near.iter().map(|face| face.map(place)).collect();
        for (vertex, normal) in vertices.iter().zip(vertex_normals(&positions, &faces)) {
            if touched.contains(vertex) {
                self.normals[*vertex as usize] = normal;
            }
        }
    }
}

/// Calls `add` with every vertex of every triangle that has an area, and the triangle's normal.
fn add_face_normals(positions: &[DVec3], faces: &[[u32; 3]], mut add: impl FnMut(usize, DVec3)) {
    for &face in faces {
        if let Some(normal) = triangle_normal(corners(positions, face)) {
            for vertex in face {
                add(vertex as usize, normal);
            }
        }
    }
}

/// The vector with length 1, in f32; `None` if it has no direction.
pub(super) fn unit(v: DVec3) -> Option<[f32; 3]> {
    v.try_normalize().map(|v| v.as_vec3().to_array())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_near_moved_vertices_are_those_of_the_whole() {
        // A strip of squares; all normals point up at first.
        let at = |i: u32| DVec3::new(f64::from(i / 2), f64::from(i % 2), 0.0);
        let squares =
            (0..5).flat_map(|i| [[2 * i, 2 * i + 2, 2 * i + 1], [2 * i + 1, 2 * i + 2, 2 * i + 3]]);
        let mut mesh = Mesh {
            positions: (0..12).map(at).collect(),
            faces: squares.collect(),
            normals: vec![[0.0, 0.6, 0.8]; 12],
            ..Mesh::default()
        };
        mesh.positions[2].z = 1.0;
        mesh.renew_normals(&BTreeSet::from([2]));
        let whole = vertex_normals(&mesh.positions, &mesh.faces);
        // Vertex 2 has faces with vertices 0 to 4.
        assert_eq!(mesh.normals[..5], whole[..5]);
        assert_eq!(mesh.normals[5..], [[0.0, 0.6, 0.8]; 7]);
        let mut flat = Mesh { normals: Vec::new(), ..mesh };
        flat.renew_normals(&BTreeSet::from([2]));
        assert!(flat.normals.is_empty());
    }
}
