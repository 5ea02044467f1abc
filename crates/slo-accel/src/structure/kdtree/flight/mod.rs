//! Rays in flight: what one instruction set does to a ray, and where rays and their stacks lie.
//!
//! A step of a ray has no branch: it computes when the ray crosses the seven planes of a treelet,
//! permutes these times to the cells between them in the order in which the ray meets those
//! ([`ways`]), and puts the cells that it does meet on its stack.

mod avx2;
mod avx512;
mod entries;
mod memory;
mod ray;
#[cfg(test)]
mod tests;
mod vector;
mod ways;

pub(super) use self::entries::{Line, stack_size};
pub(super) use self::memory::{Flights, Memory};
pub(super) use self::ray::Ray;
pub(super) use self::vector::{ShearedLanes, Vector};
pub(super) use self::ways::{axes, row};

/// Lines of a [`Ray`].
pub(super) const RAY_LINES: usize = size_of::<Ray>() / size_of::<Line>();
