//! `box`

use super::geometry::Geometry;
use super::quads::flat;
use slo_scene::shape::{Cuboid, Rectangle};

/// Returns six faces, counter-clockwise seen from outside. uv covers the unit square on each face.
pub(super) fn geometry(&Cuboid { vertices, height }: &Cuboid) -> Geometry {
    let [a, b, c, d] = Rectangle { vertices }.corners();
    let out = (c - b).cross(a - b).normalize();
    let up = out * height;
    let [e, f, g, h] = [a, b, c, d].map(|p| p + up);
    let faces =
        [[a, b, f, e], [b, c, g, f], [c, d, h, g], [d, a, e, h], [e, f, g, h], [d, c, b, a]];
    // The corners run counter-clockwise about `out`. A negative height reverses all faces.
    flat(&if height >= 0.0 { faces } else { faces.map(|[p, q, r, s]| [s, r, q, p]) })
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn box_faces_look_outward() {
        let vertices = [DVec3::ZERO, DVec3::X * 2.0, DVec3::new(2.0, 3.0, 0.0)];
        for height in [4.0, -4.0] {
            let Geometry::Mesh(mesh, _) = geometry(&Cuboid { vertices, height }) else {
                panic!("not flat")
            };
            assert_eq!(mesh.faces.len(), 12);
            let center = DVec3::new(1.0, 1.5, height / 2.0);
            let volume: f64 = mesh
                .faces
                .iter()
                .map(|face| {
                    let [a, b, c] = face.map(|i| mesh.positions[i as usize]);
                    let outward = (b - a).cross(c - a).dot(a - center);
                    assert!(outward > 0.0, "face {face:?} at height {height}");
                    outward / 6.0
                })
                .sum();
            assert!((volume - 24.0).abs() < 1e-9);
        }
    }
}
