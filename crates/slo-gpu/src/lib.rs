//! Traverses the structures to study of `slo-accel` on a GPU: uniform grid, kd-tree with a short stack, and
//! binary hierarchy of boxes, by compute programs in WGSL that wgpu runs on Vulkan.
//!
//! A `Gpu` is a [`slo_accel::Device`]: `slo_accel::Structure::build_on` builds a structure on the CPU and
//! gives it to the device, which answers batches of rays from then on. The programs follow the
//! CPU's traversals step by step, so their hits and counters can be compared one by one.
//!
//! Without the feature `device` the crate is empty, and nothing of wgpu is compiled.

#[cfg(feature = "device")]
mod adapter;
#[cfg(feature = "device")]
mod desk;
#[cfg(feature = "device")]
mod failure;
#[cfg(feature = "device")]
mod gpu;
#[cfg(feature = "device")]
mod packed;
#[cfg(feature = "device")]
mod program;
#[cfg(feature = "device")]
mod resident;
#[cfg(feature = "device")]
mod shared;

#[cfg(feature = "device")]
pub use adapter::{Adapter, adapters};
#[cfg(feature = "device")]
pub use gpu::Gpu;
