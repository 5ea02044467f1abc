//! Solids as triangles, where slo-rt has none that say the same.

use glam::DVec3;

use crate::model::Mesh;

/// Sides of round things.
pub(crate) const SIDES: u32 = 64;

/// Adds the side of a cone or cylinder, with normals. Its tip is a point if a radius is 0.
pub(crate) fn add_side(mesh: &mut Mesh, [base, top]: [DVec3; 2], [r0, r1]: [f64; 2]) {
    let axis = top - base;
    let along = axis.normalize();
    let (x, y) = along.any_orthonormal_pair();
    let slope = (r0 - r1) / axis.length();
    let first = mesh.positions.len() as u32;
    for i in 0..=SIDES {
        let out = around(x, y, i);
        let normal = (out + along * slope).normalize().as_vec3().to_array();
        for (center, radius) in [(base, r0), (top, r1)] {
            mesh.positions.push((center + out * radius).as_vec3().to_array());
            mesh.normals.push(normal);
        }
    }
    for i in 0..SIDES {
        let [a, b, c, d] = [0, 2, 3, 1].map(|k| first + 2 * i + k);
        if r0 > 0.0 {
            mesh.faces.push([a, b, c]);
        }
        // A tip is one point, so one half has no area.
        if r1 > 0.0 {
            mesh.faces.push([a, c, d]);
        }
    }
}

/// Adds a round face about a point, which looks along `normal`.
pub(crate) fn add_disc(mesh: &mut Mesh, center: DVec3, normal: DVec3, radius: f64) {
    let (x, y) = normal.any_orthonormal_pair();
    let first = mesh.positions.len() as u32;
    for i in 0..SIDES {
        mesh.positions.push((center + around(x, y, i) * radius).as_vec3().to_array());
        mesh.normals.push(normal.as_vec3().to_array());
    }
    mesh.faces.extend((1..SIDES - 1).map(|i| [first, first + i, first + i + 1]));
}

/// A sphere.
pub(crate) fn sphere(center: DVec3, radius: f64) -> Mesh {
    let mut mesh = Mesh::default();
    let rows = SIDES / 2;
    for row in 0..=rows {
        let angle = std::f64::consts::PI * f64::from(row) / f64::from(rows);
        for i in 0..=SIDES {
            let out =
                around(DVec3::X, DVec3::Y, i) * libm::sin(angle) + DVec3::Z * libm::cos(angle);
            mesh.positions.push((center + out * radius).as_vec3().to_array());
            mesh.normals.push(out.as_vec3().to_array());
        }
    }
    for row in 0..rows {
        for i in 0..SIDES {
            let a = row * (SIDES + 1) + i;
            let (b, c, d) = (a + SIDES + 1, a + SIDES + 2, a + 1);
            if row > 0 {
                mesh.faces.push([a, b, d]);
            }
            if row + 1 < rows {
                mesh.faces.push([b, c, d]);
            }
        }
    }
    mesh
}

/// A box around the origin, with half of its sides.
pub(crate) fn cuboid(half: DVec3) -> Mesh {
    let corner = |i: usize| {
        let sign = |bit: usize| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
        (half * DVec3::new(sign(0), sign(1), sign(2))).as_vec3().to_array()
    };
    let faces =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let polygons = faces.map(|face| face.to_vec()).to_vec();
    Mesh { positions: (0..8).map(corner).collect(), polygons, ..Mesh::default() }
}

fn around(x: DVec3, y: DVec3, side: u32) -> DVec3 {
    let angle = std::f64::consts::TAU * f64::from(side % SIDES) / f64::from(SIDES);
    x * libm::cos(angle) + y * libm::sin(angle)
}
