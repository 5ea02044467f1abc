//! Columns of numbers, bounds, elementary functions and rounding bounds.

mod bounds;
pub mod columns;
pub mod elementary;
pub mod rounding;

pub use bounds::Bounds;
