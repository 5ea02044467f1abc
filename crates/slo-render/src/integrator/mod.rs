//! Batches of weighted rays -> radiance. Knows no files and no threads.
//!
//! A sample is a sum over a tree of rays. Every ray carries the weight that radiance arriving along it
//! has for the pixel, so the tree needs no way back: a hit adds its own light and puts the rays that
//! it sends out into queues, which are worked off a batch at a time until none is left. Exact sums
//! make the order irrelevant.
//!
//! - `machine` has the queues, decides which batch comes next, and adds up; it knows no light.
//! - `stages` turn columns into columns, each with its own working memory.
//! - An integrator lists its stages and how they branch: `distributed`.

mod batch;
mod branching;
mod chosen;
mod distributed;
mod machine;
mod queue;
mod roulette;
mod stages;
mod sums;
mod tracer;
mod work;

pub use tracer::Tracer;
pub use work::{SampleSum, Statistics, Traced, Work};
