//! Shapes other than meshes.

use glam::DVec3;

use super::fields::Fields;
use super::values::{Bound, Found, SHORTEST};
use crate::Shape;
use crate::diagnostics::Diagnostic;

/// Side of a `plane`, before `Scaling`.
const PLANE_SIDE: f64 = 1000.0;

/// Cosine between the sides of a rectangle past which it gets a warning: 0.06 degrees, which
/// corners that were rounded to three digits keep.
const RIGHT_ANGLE_TOLERANCE: f64 = 1e-3;

/// Sine between two sides below which a triangle has no area.
const LEAST_SINE: f64 = 1e-9;

/// `plane`
pub(super) fn plane(fields: &mut Fields<'_, '_, '_>) -> Option<Shape> {
    let normal = fields.direction("normal");
    let position = fields.point("position");
    let side = PLANE_SIDE * fields.scale;
    Some(Shape::Plane { normal: normal?.value, position: position?.value, side })
}

/// `sphere`
pub(super) fn sphere(fields: &mut Fields<'_, '_, '_>) -> Option<Shape> {
    let center = fields.point("center");
    let radius = fields.length("radius", Bound::Positive);
    Some(Shape::Sphere { center: center?.value, radius: radius?.value })
}

/// `triangle`
pub(super) fn triangle(fields: &mut Fields<'_, '_, '_>) -> Option<Shape> {
    Some(Shape::Triangle { vertices: corners(fields, false)? })
}

/// `rectangle`
pub(super) fn rectangle(fields: &mut Fields<'_, '_, '_>) -> Option<Shape> {
    Some(Shape::Rectangle { vertices: corners(fields, true)? })
}

/// `box`
pub(super) fn cuboid(fields: &mut Fields<'_, '_, '_>) -> Option<Shape> {
    let vertices = corners(fields, true);
    let height = fields.length("height", Bound::NotZero);
    Some(Shape::Box { vertices: vertices?, height: height?.value })
}

/// `cylinder`
pub(super) fn cylinder(fields: &mut Fields<'_, '_, '_>) -> Option<Shape> {
    let [base, top] = axis(fields, "base", "top")?;
    let radius = fields.length("radius", Bound::Positive)?.value;
    Some(Shape::Cylinder { base, top, radius })
}

/// `cone`
pub(super) fn cone(fields: &mut Fields<'_, '_, '_>) -> Option<Shape> {
    let [base, apex] = axis(fields, "base", "apex")?;
    let radius = fields.length("radius", Bound::Positive)?.value;
    Some(Shape::Cone { base, apex, radius })
}

/// Two points that are apart.
fn axis(fields: &mut Fields<'_, '_, '_>, from: &str, to: &str) -> Option<[DVec3; 2]> {
    let (start, end) = (fields.point(from), fields.point(to));
    let (start, end) = (start?, end?);
    if end.value.distance(start.value) < SHORTEST {
        let message = format!("{} has no height", fields.element.title());
        fields.diagnostics.push(
            Diagnostic::error(message)
                .at(end.span, format!("`{to}` is where `{from}` is"))
                .also(start.span, format!("`{from}`")),
        );
        return None;
    }
    Some([start.value, end.value])
}

/// `vertex0`, `vertex1` and `vertex2`, checked for an area and, where they are corners of a
/// rectangle, for its right angle.
pub(super) fn corners(fields: &mut Fields<'_, '_, '_>, of_rectangle: bool) -> Option<[DVec3; 3]> {
    let [a, b, c] = ["vertex0", "vertex1", "vertex2"].map(|name| fields.point(name));
    let found = [a?, b?, c?];
    let vertices = found.map(|f| f.value);
    let (u, v) = if of_rectangle {
        (vertices[0] - vertices[1], vertices[2] - vertices[1])
    } else {
        (vertices[1] - vertices[0], vertices[2] - vertices[0])
    };
    let shortest = u.length().min(v.length()).min((u - v).length());
    if shortest < SHORTEST || u.cross(v).length() <= LEAST_SINE * u.length() * v.length() {
        report_no_area(fields, &found);
        return None;
    }
    let cosine = u.dot(v) / (u.length() * v.length());
    if of_rectangle && cosine.abs() > RIGHT_ANGLE_TOLERANCE {
        warn_of_angle(fields, &found, cosine);
    }
    Some(vertices)
}

fn report_no_area(fields: &mut Fields<'_, '_, '_>, corners: &[Found<DVec3>; 3]) {
    let [a, b, c] = corners;
    let message = format!("{} has no area", fields.element.title());
    let label = if a.value == b.value || b.value == c.value || a.value == c.value {
        "two corners are the same point"
    } else {
        "the corners lie on one line"
    };
    let diagnostic = Diagnostic::error(message).at(fields.element.head(), "");
    fields.diagnostics.push(diagnostic.also(a.span.to(c.span), label));
}

fn warn_of_angle(fields: &mut Fields<'_, '_, '_>, corners: &[Found<DVec3>; 3], cosine: f64) {
    let degrees = libm::acos(cosine).to_degrees();
    let message = format!("{} is not a rectangle", fields.element.title());
    let label = format!("the angle at this corner is {degrees:.1} degrees");
    fields.diagnostics.push(
        Diagnostic::warning(message)
            .at(corners[1].span, label)
            .help("the corners are consecutive: `vertex1` lies between the other two"),
    );
}
