//! Films in files: checkpoints, parts, pictures that may get more samples.

mod check;
mod file;
#[cfg(test)]
mod tests;

pub(super) use file::MAGIC;
pub use file::{read_state, read_subject, write_state};
