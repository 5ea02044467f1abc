//! Boxes of objects of scenes of the Standard Procedural Databases (Haines, *A Proposal for Standard
//! Graphics Environments*, IEEE CG&A 1987), in their usual sizes.

use glam::{DMat3, DVec3};

use crate::math::Bounds;

fn bounds(min: DVec3, max: DVec3) -> Bounds {
    Bounds { min: min.as_vec3(), max: max.as_vec3() }
}

fn ball(center: DVec3, radius: f64) -> Bounds {
    bounds(center - radius, center + radius)
}

/// A lattice of spheres and cylinders: 2197 + 6084. Boxes of cylinders are the smallest, or hold
/// balls about their ends, as the boxes of some programs do.
pub(super) fn lattice(with_balls: bool) -> Vec<Bounds> {
    let size = 12.0;
    let mut boxes = vec![];
    for i in 0..13 * 13 * 13 {
        let place = [i % 13, i / 13 % 13, i / 169].map(f64::from);
        boxes.push(ball(DVec3::from_array(place) / size, 0.25 / size));
        for axis in (0..3).filter(|&axis| place[axis] < size) {
            let radius = DVec3::splat(0.0625 / size);
            let (mut min, mut max) = (
                DVec3::from_array(place) / size - radius,
                DVec3::from_array(place) / size + radius,
            );
            let end = if with_balls { 0.12375 - 0.0625 } else { 0.12375 };
            min[axis] = (place[axis] + end) / size;
            max[axis] = (place[axis] + 1.0 - end) / size;
            boxes.push(bounds(min, max));
        }
    }
    boxes
}

/// A tetrahedron of tetrahedra: 4096 triangles.
pub(super) fn tetra() -> Vec<Bounds> {
    let corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    let corners = corners.map(DVec3::from_array);
    let mut boxes = vec![];
    // The five base-4 digits of a number are the way from the whole to a part of five levels.
    for number in 0..4usize.pow(5) {
        let mut center = DVec3::ZERO;
        for level in 0..5 {
            center += corners[number >> (2 * level) & 3] / f64::from(2 << level);
        }
        for left_out in 0..4 {
            let face = (0..4).filter(|&i| i != left_out);
            let face = face.map(|i| (center + corners[i] / 32.0).as_vec3());
            boxes.push(Bounds::of_points(face));
        }
    }
    boxes
}

/// A turn about a unit axis.
fn turn(axis: DVec3, cosine: f64, sine: f64) -> DMat3 {
    let [x, y, z] = axis.to_array();
    let cross = DMat3::from_cols_array(&[0.0, z, -y, -z, 0.0, x, y, -x, 0.0]);
    let outer = DMat3::from_cols(axis * x, axis * y, axis * z);
    DMat3::IDENTITY * cosine + cross * sine + outer * (1.0 - cosine)
}

/// A sphereflake on a square: 7381 + 1.
pub(super) fn balls() -> Vec<Bounds> {
    let trio = [[1.0, 1.0, 0.0], [1.0, 0.0, -1.0], [0.0, 1.0, -1.0]].map(DVec3::from_array);
    let axis = DVec3::new(1.0, -1.0, 0.0).normalize();
    let sine = 2.0 / 6.0f64.sqrt();
    let up = turn(axis, (1.0 - sine * sine).sqrt(), sine);
    let third = turn(DVec3::Z, -0.5, 0.75f64.sqrt());
    let mut directions = vec![];
    for number in 0..9 {
        let mut direction = up * trio[number % 3].normalize();
        (0..number / 3).for_each(|_| direction = third * direction);
        directions.push(direction);
    }
    let corner = DVec3::new(12.0, 12.0, 0.0);
    let below = -0.5 * DVec3::Z;
    let mut boxes = vec![bounds(below - corner, below + corner)];
    let mut flakes = vec![(DVec3::ZERO, 0.5, DVec3::Z, 0)];
    while let Some((center, radius, direction, depth)) = flakes.pop() {
        boxes.push(ball(center, radius));
        if depth == 4 {
            continue;
        }
        let across = DVec3::Z.cross(direction);
        let turn = if across.length() > 1e-9 {
            turn(across.normalize(), direction.z, across.length())
        } else {
            turn(DVec3::X, direction.z.signum(), 0.0)
        };
        for &child in &directions {
            let child = turn * child;
            flakes.push((center + child * (radius * 4.0 / 3.0), radius / 3.0, child, depth + 1));
        }
    }
    boxes
}
