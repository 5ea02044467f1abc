//! Shapes as primitives: flat shapes become small meshes, curved ones stay what they are.

use std::sync::Arc;

use glam::{DVec3, Vec3};

use slo_accel::curved::Part;
use slo_scene::{Mesh, Shape};

/// What a shape consists of, in object space.
#[derive(Clone, Debug)]
pub(super) enum Geometry {
    /// Triangles, and whether their vertex normals are interpolated.
    Mesh(Arc<Mesh>, bool),
    /// One curved surface.
    Curved(CurvedShape),
}

/// A curved surface in f64.
#[derive(Clone, Copy, Debug)]
pub(super) enum CurvedShape {
    Sphere { center: DVec3, radius: f64 },
    Cylinder { base: DVec3, top: DVec3, radius: f64 },
    Cone { base: DVec3, apex: DVec3, radius: f64 },
}

impl CurvedShape {
    /// uv at a point of the surface, in object space.
    ///
    /// u runs once around the axis (z for a sphere), from x where the axis is z; v from the lower
    /// pole or the base to the upper pole or the tip. A disc shows the image's inscribed circle.
    pub(super) fn uv_at(&self, point: Vec3, part: Part) -> [f32; 2] {
        let (base, axis, radius) = match *self {
            Self::Sphere { center, radius } => (center, DVec3::Z, radius),
            Self::Cylinder { base, top, radius } | Self::Cone { base, apex: top, radius } => {
                (base, top - base, radius)
            }
        };
        let length = axis.length();
        let axis = axis / length;
        let x = if axis.z.abs() > 1.0 - 1e-9 { DVec3::X } else { DVec3::Z.cross(axis).normalize() };
        let y = axis.cross(x);
        let p = point.as_dvec3() - base;
        if part != Part::Side {
            return [p.dot(x), p.dot(y)].map(|c| (0.5 + 0.5 * c / radius) as f32);
        }
        let turns = libm::atan2(p.dot(y), p.dot(x)) / std::f64::consts::TAU;
        let v = match self {
            Self::Sphere { .. } => {
                0.5 + libm::asin((p.dot(axis) / radius).clamp(-1.0, 1.0)) / std::f64::consts::PI
            }
            _ => p.dot(axis) / length,
        };
        [(turns - turns.floor()) as f32, v as f32]
    }
}

/// The geometry of a shape.
pub(super) fn geometry(shape: &Shape) -> Geometry {
    match *shape {
        Shape::Plane { normal, position, side } => flat(&[plane(normal, position, side)]),
        Shape::Triangle { vertices: [a, b, c] } => {
            Geometry::Mesh(Arc::new(triangle(a, b, c)), false)
        }
        Shape::Rectangle { vertices } => flat(&[rectangle(vertices)]),
        Shape::Box { vertices, height } => flat(&box_faces(vertices, height)),
        Shape::Sphere { center, radius } => {
            Geometry::Curved(CurvedShape::Sphere { center, radius })
        }
        Shape::Cylinder { base, top, radius } => {
            Geometry::Curved(CurvedShape::Cylinder { base, top, radius })
        }
        Shape::Cone { base, apex, radius } => {
            Geometry::Curved(CurvedShape::Cone { base, apex, radius })
        }
        Shape::Mesh { ref mesh, smooth } => Geometry::Mesh(Arc::clone(mesh), smooth),
    }
}

/// A rectangle by four corners in order; uv runs from (0, 0) at the first along the second to
/// (1, 1) at the third.
type Quad = [DVec3; 4];

/// The visible surface of a light.
pub(super) fn light_rectangle(vertices: [DVec3; 3]) -> Geometry {
    flat(&[rectangle(vertices)])
}

/// The rectangle of three consecutive corners.
fn rectangle([v0, v1, v2]: [DVec3; 3]) -> Quad {
    [v0, v1, v2, v0 + v2 - v1]
}

/// The square about `position`; its first side lies in the xy plane where the normal allows it.
fn plane(normal: DVec3, position: DVec3, side: f64) -> Quad {
    let n = normal.normalize();
    let x = if n.x.abs() < 1e-9 && n.y.abs() < 1e-9 { DVec3::X } else { DVec3::Z.cross(n) };
    let x = x.normalize() * (side * 0.5);
    let y = n.cross(x);
    [position - x - y, position + x - y, position + x + y, position - x + y]
}

/// The six faces, counter-clockwise seen from outside; uv over each face.
fn box_faces(vertices: [DVec3; 3], height: f64) -> [Quad; 6] {
    let [a, b, c, d] = rectangle(vertices);
    let out = (c - b).cross(a - b).normalize();
    let up = out * height;
    let [e, f, g, h] = [a, b, c, d].map(|p| p + up);
    let faces =
        [[a, b, f, e], [b, c, g, f], [c, d, h, g], [d, a, e, h], [e, f, g, h], [d, c, b, a]];
    // The corners run counter-clockwise about `out`; a negative height turns all faces round.
    if height >= 0.0 { faces } else { faces.map(|[p, q, r, s]| [s, r, q, p]) }
}

fn flat(quads: &[Quad]) -> Geometry {
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

fn triangle(a: DVec3, b: DVec3, c: DVec3) -> Mesh {
    Mesh {
        positions: vec![a, b, c],
        faces: vec![[0, 1, 2]],
        uvs: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]],
        face_uvs: vec![[0, 1, 2]],
        ..Mesh::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn normal(mesh: &Mesh, face: usize) -> DVec3 {
        let [a, b, c] = mesh.faces[face].map(|i| mesh.positions[i as usize]);
        (b - a).cross(c - a)
    }

    fn mesh_of(shape: &Shape) -> Arc<Mesh> {
        match geometry(shape) {
            Geometry::Mesh(mesh, _) => mesh,
            Geometry::Curved(_) => panic!("not flat"),
        }
    }

    #[test]
    fn box_faces_look_outward() {
        let vertices = [DVec3::ZERO, DVec3::X * 2.0, DVec3::new(2.0, 3.0, 0.0)];
        for height in [4.0, -4.0] {
            let mesh = mesh_of(&Shape::Box { vertices, height });
            assert_eq!(mesh.faces.len(), 12);
            let center = DVec3::new(1.0, 1.5, height / 2.0);
            let volume: f64 = (0..12)
                .map(|f| {
                    let p = mesh.positions[mesh.faces[f][0] as usize] - center;
                    assert!(normal(&mesh, f).dot(p) > 0.0, "face {f} at height {height}");
                    normal(&mesh, f).dot(p) / 6.0
                })
                .sum();
            assert!((volume - 24.0).abs() < 1e-9);
        }
    }

    #[test]
    fn a_plane_is_a_square_across_its_normal() {
        for n in [DVec3::Z, DVec3::NEG_Z, DVec3::X, DVec3::new(1.0, 2.0, -3.0)] {
            let position = DVec3::new(1.0, 2.0, 3.0);
            let mesh = mesh_of(&Shape::Plane { normal: n, position, side: 1000.0 });
            let [a, b, c, d]: Quad = mesh.positions.as_slice().try_into().unwrap();
            for (p, q) in [(a, b), (b, c), (c, d), (d, a)] {
                assert!((p.distance(q) - 1000.0).abs() < 1e-6);
            }
            assert!(((a + c) / 2.0).distance(position) < 1e-9);
            assert!(normal(&mesh, 0).normalize().distance(n.normalize()) < 1e-12);
        }
    }
}
