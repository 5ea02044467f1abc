use glam::{DVec3, Vec3};
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

use super::*;

/// A mesh with tangents, whose corners have the uvs of their vertices.
fn mesh(positions: Vec<DVec3>, faces: Vec<[u32; 3]>, uvs: Vec<[f32; 2]>) -> Mesh {
    let face_uvs = faces.clone();
    let mut mesh = Mesh { positions, faces, uvs, face_uvs, ..Mesh::default() };
    mesh.add_tangents();
    assert!(mesh.is_consistent(false));
    assert_eq!(mesh.tangents.len(), mesh.faces.len());
    for tangent in mesh.tangents.as_flattened() {
        let [x, y, z, side] = tangent.unpacked();
        assert!((x * x + y * y + z * z - 1.0).abs() < 1e-5 && side.abs() == 1.0);
    }
    mesh
}

/// Two triangles in the xy plane with the given uvs at (0 0), (1 0), (1 1), (0 1).
fn square(uvs: [[f32; 2]; 4], size: f64) -> Mesh {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let corners = corners.map(|[x, y]| DVec3::new(x * size, y * size, 0.0));
    mesh(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]], uvs.to_vec())
}

/// Asserts that all corners have a tangent.
fn assert_all(mesh: &Mesh, expected: [f32; 4]) {
    for tangent in mesh.tangents.as_flattened() {
        let found = tangent.unpacked();
        let error = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(error < 2e-4, "{found:?} instead of {expected:?}");
    }
}

#[test]
fn the_tangent_is_where_u_grows() {
    let plain = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    for size in [1.0, 1e-8, 1e8] {
        assert_all(&square(plain, size), [1.0, 0.0, 0.0, 1.0]);
        assert_all(&square(plain.map(|[u, v]| [-3.0 * u, v]), size), [-1.0, 0.0, 0.0, -1.0]);
        assert_all(&square(plain.map(|[u, v]| [v, u]), size), [0.0, 1.0, 0.0, -1.0]);
        assert_all(&square(plain.map(|[u, v]| [v, -u]), size), [0.0, 1.0, 0.0, 1.0]);
    }
    let turned = std::f32::consts::FRAC_1_SQRT_2;
    assert_all(&square(plain.map(|[u, v]| [u + v, v - u]), 1.0), [turned, turned, 0.0, 1.0]);
}

#[test]
fn tangents_of_a_smooth_mesh_are_shared_and_follow_its_normals() {
    let (columns, rows) = (24, 12);
    let (mut positions, mut uvs, mut faces) = (Vec::new(), Vec::new(), Vec::new());
    for row in 0..=rows {
        for column in 0..=columns {
            let (u, v) = (column as f64 / columns as f64, row as f64 / rows as f64);
            let (sin, cos) = libm::sincos(u * std::f64::consts::TAU);
            let (height, radius) = libm::sincos((v - 0.5) * 2.0);
            positions.push(DVec3::new(radius * cos, radius * sin, height));
            uvs.push([u as f32, v as f32]);
            if row < rows && column < columns {
                let at = row * (columns + 1) + column;
                faces.push([at, at + 1, at + columns + 2]);
                faces.push([at, at + columns + 2, at + columns + 1]);
            }
        }
    }
    let normals = positions.iter().map(|p| p.normalize().as_vec3().to_array()).collect();
    let face_uvs = faces.clone();
    let mut mesh = Mesh { positions, faces, normals, uvs, face_uvs, ..Mesh::default() };
    mesh.add_tangents();
    let mut of_vertices = vec![None; mesh.positions.len()];
    for (face, tangents) in mesh.faces.iter().zip(&mesh.tangents) {
        for (vertex, tangent) in face.iter().zip(tangents) {
            let vertex = *vertex as usize;
            assert_eq!(*of_vertices[vertex].get_or_insert(*tangent), *tangent);
            let [x, y, z, side] = tangent.unpacked();
            assert!(Vec3::from_array(mesh.normals[vertex]).dot(Vec3::new(x, y, z)).abs() < 2e-4);
            let position = mesh.positions[vertex].as_vec3();
            let along = Vec3::new(-position.y, position.x, 0.0).normalize();
            // At the seam only the triangles of one side count.
            assert!(along.dot(Vec3::new(x, y, z)) > 0.99, "{position} {x} {y} {z}");
            assert_eq!(side, 1.0);
        }
    }
}

#[test]
fn uvs_without_area_give_some_tangent_along_the_surface() {
    for uvs in [[[0.5, 0.5]; 4], [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]]] {
        for tangent in square(uvs, 1.0).tangents.as_flattened() {
            assert_eq!(tangent.unpacked()[2], 0.0);
        }
    }
    let mut without = Mesh { faces: vec![[0, 1, 2]], ..Mesh::default() };
    without.add_tangents();
    assert!(without.tangents.is_empty());
}

#[test]
fn a_vertex_or_an_edge_may_have_any_number_of_triangles() {
    let count = 20_000;
    let (mut positions, mut uvs) = (vec![DVec3::ZERO], vec![[0.0; 2]]);
    for i in 0..count {
        let (sin, cos) = libm::sincos(f64::from(i) / f64::from(count) * std::f64::consts::TAU);
        positions.push(DVec3::new(cos, sin, 0.0));
        uvs.push([cos as f32, sin as f32]);
    }
    let fan = (0..count).map(|i| [0, 1 + i, 1 + (i + 1) % count]).collect();
    assert_all(&mesh(positions.clone(), fan, uvs.clone()), [1.0, 0.0, 0.0, 1.0]);
    let hinge = (0..count - 1).map(|i| [0, 1, 2 + i]).collect();
    mesh(positions, hinge, uvs);
}

#[test]
fn no_mesh_stops_the_algorithm() {
    let mut rng = StdRng::seed_from_u64(2008);
    for round in 0..300 {
        let vertices = rng.random_range(3..20_u32);
        // Few values, so that vertices, edges and uvs coincide.
        let steps = if round % 3 == 0 { 2 } else { 1000 };
        let value = |rng: &mut StdRng| f64::from(rng.random_range(-steps..=steps));
        let positions =
            (0..vertices).map(|_| DVec3::from_array([0; 3].map(|_| value(&mut rng)))).collect();
        let uvs = (0..vertices).map(|_| [0; 2].map(|_| value(&mut rng) as f32)).collect();
        let corner = |rng: &mut StdRng| rng.random_range(0..vertices);
        let faces = (0..40).map(|_| [0; 3].map(|_| corner(&mut rng))).collect();
        mesh(positions, faces, uvs);
    }
    let far = [[f32::MAX, 0.0], [-f32::MAX, 1.0], [0.0, f32::MAX], [f32::MIN_POSITIVE, 0.0]];
    square(far, 1.0);
}
