//! Boxes, columns of numbers, elementary functions, and rounding.

mod bounds;
pub mod columns;
pub mod elementary;
pub mod rounding;

pub use bounds::Bounds;
