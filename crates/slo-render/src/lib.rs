//! The renderer of slo-rt: turns a frame of a scene into sums of samples.
//!
//! ```text
//! SceneDescription --frame(number)--> FrameScene --integrator, over the tiles of render--> Film
//! ```
//!
//! A picture is a pure function of (scene, frame, seed, version). It does not depend on threads,
//! tiles or instruction sets.

pub mod camera;
pub mod frame;
pub mod integrator;
pub mod photons;
pub mod render;
pub mod sampling;
pub mod shading;
