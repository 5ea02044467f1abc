//! The builder's cost model: the surface area heuristic, in tests of a block of triangles.

use crate::structure::bvh::layout::BLOCK;

/// Deeper nodes are halved, so that no input gives more than `SAH_DEPTH + 32` levels.
pub(super) const SAH_DEPTH: u32 = 48;

/// Cost of testing the boxes of a node.
pub(super) const NODE_COST: f32 = 1.0;

/// Cost of testing a curved surface.
pub(super) const CURVED_COST: f32 = 4.0;

/// Cost of a side of a split; infinite if it is empty, so that no split has an empty side.
#[inline(always)]
pub(super) fn cost(half_area: f32, count: u32) -> f32 {
    if count == 0 { f32::INFINITY } else { half_area * count.div_ceil(BLOCK as u32) as f32 }
}
