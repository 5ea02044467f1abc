//! slo-rt: a distributed ray tracer for animations.
//!
//! One picture, from left to right; data never flows back:
//!
//! ```text
//! scene text --format--> syntax tree --scene--> SceneDescription
//!     --frame(number)--> FrameScene --integrator, over the tiles of render--> Film --output--> PNG, EXR
//! ```
//!
//! A picture is a pure function of (scene, frame, seed, version): threads, tiles, and instruction
//! sets never enter it. `ARCHITECTURE.md` tells the reasons and lists the invariants.

pub mod accel;
pub mod animation;
pub mod camera;
pub mod cli;
pub mod compare;
pub mod denoise;
pub mod diagnostics;
pub mod film;
pub mod format;
pub mod frame;
pub mod integrator;
pub mod math;
pub mod output;
pub mod render;
pub mod sampling;
pub mod scene;
pub mod shading;
