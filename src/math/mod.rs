//! Columns of numbers, bounds, rigid transforms and rounding bounds. Knows nothing of the rest of slo-rt.

mod bounds;
pub(crate) mod columns;
pub mod elementary;
mod rigid;
pub mod rounding;

pub use bounds::Bounds;
pub use rigid::{DRigid, Rigid};
