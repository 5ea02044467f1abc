//! The answer of a [device](crate::Device).

use super::counting::Counts;

/// What a device found out about a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer {
    /// Number of the object; [`NO_HIT`](crate::NO_HIT) if nothing is hit.
    pub object: u32,
    /// Distance in lengths of the direction.
    pub t: f32,
    /// Weight of the second corner.
    pub u: f32,
    /// Weight of the third corner.
    pub v: f32,
    /// What the traversal took. Nothing counts boxes or mailboxes that has none.
    pub counts: Counts,
    /// Whether the answer is that of the CPU's arithmetic. The others mean nothing.
    pub is_certain: bool,
}
