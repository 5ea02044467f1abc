//! References on the sides of a plane.
//!
//! Source: Stich, Friedrich, Dietrich, as in [`spatial`](super), section 4.4: a reference stays
//! whole if that is cheaper than its pieces.

use super::cut::cut;
use super::planes::Plane;
use crate::primitives::Triangle;
use crate::structure::bvh::builder::boxes::{Box8, Reference};

/// Boxes of the sides of a plane and how many references they have, as known so far.
pub(super) struct Sides {
    boxes: [Box8; 2],
    counts: [f32; 2],
}

impl Sides {
    /// As the bins of the plane have them.
    pub(super) fn new(plane: &Plane) -> Self {
        Self { boxes: plane.sides, counts: plane.counts.map(|count| count as f32) }
    }

    /// The references that take the place of one, by side.
    pub(super) fn place(
        &mut self,
        plane: &Plane,
        reference: Reference,
        triangles: &[Triangle],
        may_cut: bool,
    ) -> [Option<Reference>; 2] {
        let bounds = reference.bounds().bounds();
        let &Plane { axis, at, .. } = plane;
        if bounds.max[axis] <= at {
            return [Some(reference), None];
        }
        if bounds.min[axis] >= at {
            return [None, Some(reference)];
        }
        let Some(triangle) = plane.cuttable(&reference, triangles) else {
            return self.keep(plane.side(&reference), reference);
        };
        let pieces = cut(triangle, bounds, axis, at)
            .map(|piece| piece.map(|piece| Reference::new(piece, reference.id())));
        match (pieces, self.cheaper_whole(reference.bounds())) {
            ([Some(_), Some(_)], None) if may_cut => pieces,
            ([Some(_), Some(_)], side) => {
                let side = side.unwrap_or(plane.side(&reference));
                self.counts[1 - side] -= 1.0;
                self.keep(side, reference)
            }
            _ => pieces,
        }
    }

    /// A whole reference on one side.
    fn keep(&mut self, side: usize, reference: Reference) -> [Option<Reference>; 2] {
        self.boxes[side] = self.boxes[side].union(reference.bounds());
        let mut kept = [None; 2];
        kept[side] = Some(reference);
        kept
    }

    /// The side on which the whole reference costs less than its pieces on both.
    fn cheaper_whole(&self, whole: &Box8) -> Option<usize> {
        let [left, right] = self.boxes.each_ref().map(Box8::half_area);
        let [n_left, n_right] = self.counts;
        let cut = left * n_left + right * n_right;
        let only_left = self.boxes[0].union(whole).half_area() * n_left + right * (n_right - 1.0);
        let only_right = left * (n_left - 1.0) + self.boxes[1].union(whole).half_area() * n_right;
        let (side, least) = if only_left <= only_right { (0, only_left) } else { (1, only_right) };
        (least < cut).then_some(side)
    }
}
