//! The box about the part of a triangle inside a cell: perfect splits of both builders.

use glam::{DVec3, Vec3};

use crate::math::Bounds;
use crate::math::rounding::{round_down, round_up};
use crate::primitives::triangle::Triangle;

/// A triangle cut by six planes has at most nine corners.
#[derive(Clone, Copy)]
struct Polygon {
    corners: [DVec3; 9],
    len: usize,
}

impl Polygon {
    fn push(&mut self, p: DVec3) {
        // Rounding may count a corner twice; more than nine would repeat one.
        if self.len < self.corners.len() {
            self.corners[self.len] = p;
            self.len += 1;
        }
    }

    /// The part on one side of the plane `axis = at`: below for `side` 1, above for -1.
    ///
    /// Source: Sutherland, Hodgman, *Reentrant Polygon Clipping*, CACM 1974.
    fn clipped(&self, axis: usize, at: f64, side: f64) -> Self {
        let mut kept = Self { corners: [DVec3::ZERO; 9], len: 0 };
        for i in 0..self.len {
            let (p, q) = (self.corners[i], self.corners[(i + 1) % self.len]);
            let (dp, dq) = (side * (p[axis] - at), side * (q[axis] - at));
            if dp <= 0.0 {
                kept.push(p);
            }
            if (dp < 0.0 && dq > 0.0) || (dp > 0.0 && dq < 0.0) {
                let mut cut = p + (q - p) * (dp / (dp - dq));
                cut[axis] = at;
                kept.push(cut);
            }
        }
        kept
    }
}

/// The box about the part of a triangle inside a cell, rounded outward but not beyond the cell;
/// none if they are apart.
pub(crate) fn clipped_bounds(triangle: &Triangle, cell: &Bounds) -> Option<Bounds> {
    let whole = Bounds::of_points(*triangle);
    let mut polygon = Polygon { corners: [DVec3::ZERO; 9], len: 3 };
    for (corner, p) in polygon.corners.iter_mut().zip(triangle) {
        *corner = p.as_dvec3();
    }
    for axis in 0..3 {
        if whole.min[axis] < cell.min[axis] {
            polygon = polygon.clipped(axis, f64::from(cell.min[axis]), -1.0);
        }
        if whole.max[axis] > cell.max[axis] {
            polygon = polygon.clipped(axis, f64::from(cell.max[axis]), 1.0);
        }
    }
    let corners = &polygon.corners[..polygon.len];
    let min = corners.iter().copied().reduce(DVec3::min)?;
    let max = corners.iter().copied().reduce(DVec3::max)?;
    let outward = Bounds {
        min: Vec3::from_array(min.to_array().map(round_down)),
        max: Vec3::from_array(max.to_array().map(round_up)),
    };
    Some(outward.intersection(*cell)).filter(|bounds| !bounds.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    const CELL: Bounds = Bounds { min: Vec3::ZERO, max: Vec3::ONE };

    #[test]
    fn what_is_inside_stays() {
        let triangle = [Vec3::splat(0.1), Vec3::new(0.9, 0.2, 0.3), Vec3::new(0.5, 0.8, 0.1)];
        assert_eq!(clipped_bounds(&triangle, &CELL), Some(Bounds::of_points(triangle)));
    }

    #[test]
    fn a_corner_cut_off_is_smaller_than_the_overlap_of_boxes() {
        let triangle =
            [Vec3::new(-1.0, 1.5, 0.5), Vec3::new(1.5, -1.0, 0.5), Vec3::new(-1.0, -1.0, 0.5)];
        let bounds = clipped_bounds(&triangle, &CELL).unwrap();
        assert!((bounds.max - Vec3::new(0.5, 0.5, 0.5)).abs().max_element() < 1e-6, "{bounds:?}");
        assert_eq!(bounds.min, Vec3::new(0.0, 0.0, 0.5));
    }

    #[test]
    fn boxes_that_overlap_around_a_triangle_that_misses() {
        let triangle =
            [Vec3::new(2.5, 0.9, 0.5), Vec3::new(0.9, 2.5, 0.5), Vec3::new(2.5, 2.5, 0.5)];
        assert!(!Bounds::of_points(triangle).intersection(CELL).is_empty());
        assert_eq!(clipped_bounds(&triangle, &CELL), None);
    }

    #[test]
    fn a_triangle_in_a_face_is_kept_flat() {
        let triangle =
            [Vec3::new(1.0, -9.0, 0.5), Vec3::new(1.0, 9.0, -9.0), Vec3::new(1.0, 9.0, 9.0)];
        let bounds = clipped_bounds(&triangle, &CELL).unwrap();
        assert_eq!((bounds.min.x, bounds.max.x), (1.0, 1.0));
    }
}
