//! Devices beside the CPU that traverse structures, and what is done so that they cannot change a hit.
//!
//! A device answers with the primitive that a ray hits and says whether it is certain. The CPU then
//! repeats the test of that one primitive, whose bits count. It traces a ray by itself if the device is
//! not certain of it, or if the test contradicts the device, and all rays from then on if the device
//! fails. What is left to trust is that a device that is certain has missed nothing nearer.

use std::fmt::Debug;

use super::study::{Counts, Layout};
use crate::primitives::Triangle;
use crate::rays::Rays;

/// A device that traverses structures.
pub trait Device: Debug + Send + Sync {
    /// Takes a structure and the triangles that it is built over, one for each object. A triangle whose
    /// corners are all the same is never hit.
    ///
    /// # Errors
    /// Why the device cannot take them, in words for the user.
    fn upload(
        &self,
        layout: &Layout<'_>,
        triangles: &[Triangle],
    ) -> Result<Box<dyn Uploaded>, String>;
}

/// A structure on a device.
pub trait Uploaded: Debug + Send + Sync {
    /// Writes an answer for each ray, and drops what `answers` held before: the first hit, or any hit if
    /// `any` is enough. May be called from several threads at a time.
    ///
    /// # Errors
    /// If the device fails: why, in words for the user. It is not asked again.
    fn trace(&self, rays: &Rays, any: bool, answers: &mut Vec<Answer>) -> Result<(), String>;

    /// Bytes held on the device.
    fn bytes(&self) -> usize;
}

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
