//! What flat lamps have in common: sampled by area, they glow on one side or on both.

use glam::Vec3;

use slo_accel::math::rounding::gamma;

/// Returns the `pdf_solid_angle` of a point of a flat lamp, at the end of `way`, that is sampled
/// uniformly by area.
#[inline(always)]
pub(super) fn density(way: Vec3, normal: Vec3, area: f32) -> f32 {
    let square = way.length_squared();
    square * square.sqrt() / (way.dot(normal).abs() * area)
}

/// Returns 1 for the front of a lamp, `back` for its back; `way` is the vector to the lamp.
#[inline(always)]
pub(super) fn side(way: Vec3, normal: Vec3, back: f32) -> f32 {
    if way.dot(normal) < 0.0 { 1.0 } else { back }
}

/// Returns the direction of a shadow ray to a `point` of a flat lamp, and the t at which it ends.
/// `size` bounds the lamp's coordinates relative to `corner`.
///
/// The margin is that of [`Rectangle`](super::Rectangle), where it is derived.
#[inline(always)]
pub(super) fn shadow_ray(
    from: Vec3,
    point: Vec3,
    normal: Vec3,
    corner: Vec3,
    size: Vec3,
) -> (Vec3, f32) {
    let direction = point - from;
    let far = (corner - from).abs() + size;
    let along = direction.abs();
    let sheared = along * (far.max_element() / along.max_element());
    let error = normal.abs().dot(corner.abs() + size + far + sheared) * gamma(32);
    (direction, (1.0 - error / direction.dot(normal).abs()).max(0.5))
}
