//! Cutting a reference in two.

use glam::Vec3;

use crate::math::Bounds;
use crate::primitives::Triangle;
use crate::primitives::clip::clipped_bounds;
use crate::primitives::triangle::POSITION_ERROR;

/// Widening of the boxes of pieces.
///
/// A hit may lie [`POSITION_ERROR`] times the distance of the triangle's farthest corner away from
/// the triangle. Nodes are widened by the largest coordinate of their box instead. For a whole
/// triangle this is the largest of its corners; but a piece may lie far nearer to the origin than
/// its triangle.
pub(super) fn margin(triangle: &Triangle) -> f32 {
    let largest = triangle.iter().fold(Vec3::ZERO, |all, p| all.max(p.abs()));
    POSITION_ERROR * largest.max_element()
}

/// The boxes about the parts of a triangle on each side of the plane `axis = at`, within the box of
/// a reference to it and widened by its [`margin`]; none if there is no part.
///
/// A box that holds a part of the triangle with its margin is left with two boxes that each hold
/// their part of the part with its margin: however often a reference is cut, a hit lies inside the
/// box of a piece.
pub(super) fn cut(
    triangle: &Triangle,
    reference: Bounds,
    axis: usize,
    at: f32,
) -> [Option<Bounds>; 2] {
    let margin = margin(triangle);
    // A whole triangle has no margin yet.
    let is_whole = reference == Bounds::of_points(*triangle);
    let outer = if is_whole { widened(reference, margin) } else { reference };
    let mut cells = [outer; 2];
    cells[0].max[axis] = at;
    cells[1].min[axis] = at;
    cells.map(|cell| {
        let piece = widened(clipped_bounds(triangle, &cell)?, margin).intersection(outer);
        (!piece.is_empty()).then_some(piece)
    })
}

fn widened(bounds: Bounds, margin: f32) -> Bounds {
    let outward = |a: Vec3, b: f32, next: fn(f32) -> f32| (a + b).map(next);
    Bounds {
        min: outward(bounds.min, -margin, f32::next_down),
        max: outward(bounds.max, margin, f32::next_up),
    }
}
