//! Normals of triangles and vertices.

use glam::DVec3;

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
