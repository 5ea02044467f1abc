//! `plane`

use glam::DVec3;

use super::geometry::Geometry;
use super::quads::flat;
use slo_scene::shape::Plane;

/// Returns a square across the normal. Its first side is parallel to the xy plane.
pub(super) fn geometry(&Plane { normal, position, side }: &Plane) -> Geometry {
    let n = normal.normalize();
    let x = if n.x.abs() < 1e-9 && n.y.abs() < 1e-9 { DVec3::X } else { DVec3::Z.cross(n) };
    let x = x.normalize() * (side * 0.5);
    let y = n.cross(x);
    flat(&[[position - x - y, position + x - y, position + x + y, position - x + y]])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_is_a_square_across_its_normal() {
        for n in [DVec3::Z, DVec3::NEG_Z, DVec3::X, DVec3::new(1.0, 2.0, -3.0)] {
            let position = DVec3::new(1.0, 2.0, 3.0);
            let Geometry::Mesh(mesh, _) = geometry(&Plane { normal: n, position, side: 1000.0 })
            else {
                panic!("not flat")
            };
            let [a, b, c, d]: [DVec3; 4] = mesh.positions.as_slice().try_into().unwrap();
            for (p, q) in [(a, b), (b, c), (c, d), (d, a)] {
                assert!((p.distance(q) - 1000.0).abs() < 1e-6);
            }
            assert!(((a + c) / 2.0).distance(position) < 1e-9);
            let normal = (b - a).cross(c - a).normalize();
            assert!(normal.distance(n.normalize()) < 1e-12);
        }
    }
}
