//! The renderer of slo-rt: a frame of a scene becomes sums of samples.
//!
//! ```text
//! SceneDescription --frame(number)--> FrameScene --integrator, over the tiles of render--> Film
//! ```
//!
//! A picture is a pure function of (scene, frame, seed, version): threads, tiles and instruction sets never
//! enter it.

pub mod camera;
pub mod frame;
pub mod integrator;
pub mod render;
pub mod sampling;
pub mod shading;
