//! Structures that answer batches of rays: which primitive is hit first, or whether any is.

mod box_tree;
mod isa;
pub mod math;
mod primitives;
mod rays;
#[cfg_attr(not(target_arch = "x86_64"), allow(dead_code))]
mod simd;
mod structure;

pub use box_tree::{BoxScratch, BoxTree};
pub use isa::compress::{GROUP, Word};
pub use isa::{Isa, Lanewise};
pub use primitives::{Curved, Primitives, Triangle, curved, triangle};
pub use rays::{Coherence, Hits, LANES, NO_HIT, Rays};
pub use structure::{Accelerator, BuildOptions, Scratch, Structure};
