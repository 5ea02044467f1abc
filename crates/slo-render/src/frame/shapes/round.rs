//! Surfaces of revolution about an axis.

use glam::{DVec3, Vec3};

use crate::frame::sampled_motion::ObjectBox;
use slo_accel::curved::Part;

/// Returns uv at a point of a surface of revolution, or of a disc at one of its ends. `v` returns v
/// at a point of the surface, given the point's position along the axis and the length of the axis.
pub(super) fn uv_about(
    [base, axis]: [DVec3; 2],
    radius: f64,
    point: Vec3,
    part: Part,
    v: impl FnOnce(f64, f64) -> f64,
) -> [f32; 2] {
    let length = axis.length();
    let axis = axis / length;
    let x = start(axis);
    let y = axis.cross(x);
    let p = point.as_dvec3() - base;
    if part != Part::Side {
        return [p.dot(x), p.dot(y)].map(|c| (0.5 + 0.5 * c / radius) as f32);
    }
    let turns = libm::atan2(p.dot(y), p.dot(x)) / std::f64::consts::TAU;
    [(turns - turns.floor()) as f32, v(p.dot(axis), length) as f32]
}

/// Returns the direction, of length 1, in which u starts around a unit axis. It is also that in which
/// u grows on discs at the ends.
fn start(axis: DVec3) -> DVec3 {
    if axis.z.abs() > 1.0 - 1e-9 { DVec3::X } else { DVec3::Z.cross(axis).normalize() }
}

/// Returns the unit vector along which u of [`uv_about`] grows at a point.
pub(in crate::frame) fn tangent_about([base, axis]: [DVec3; 2], point: Vec3, part: Part) -> Vec3 {
    let x = start(axis.normalize());
    let around = axis.cross(point.as_dvec3() - base);
    let turns = part == Part::Side && around.length_squared() > 0.0;
    if turns { around.normalize().as_vec3() } else { x.as_vec3() }
}

/// Returns the bounding box of balls of one radius.
pub(super) fn about_balls(centers: &[DVec3], radius: f64) -> ObjectBox {
    let radius = DVec3::splat(radius);
    ObjectBox::about(centers.iter().flat_map(|&center| [center - radius, center + radius]))
}
