//! The `.slo` mesh format: see docs/scene-format.md.

mod faults;
mod indices;
mod reader;
mod section;
#[cfg(test)]
mod tests;
mod values;
mod words;
mod writer;

pub use reader::read;
pub use writer::write_slo;
