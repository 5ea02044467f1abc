//! Triangles and rectangles by three corners.

use glam::DVec3;

use crate::attributes::schema::{Attribute, point};
use crate::attributes::{Fields, Found, SHORTEST};
use crate::diagnostics::Diagnostic;

/// Cosine between the sides of a rectangle past which it gets a warning: 0.06 degrees, which
/// corners that were rounded to three digits keep.
const RIGHT_ANGLE_TOLERANCE: f64 = 1e-3;

/// Sine between two sides below which a triangle has no area.
const LEAST_SINE: f64 = 1e-9;

/// The attributes that [`corners`] reads.
pub(crate) const CORNERS: [Attribute; 3] =
    [point("vertex0").required(), point("vertex1").required(), point("vertex2").required()];

/// `vertex0`, `vertex1` and `vertex2`, checked for an area and, if they are corners of a
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
