//! slo-rt: a distributed ray tracer for animations.
//!
//! ```no_run
//! use slo_rt::{Render, Scene};
//!
//! fn main() -> Result<(), slo_rt::Error> {
//!     let scene = Scene::open("scenes/table.txt")?;
//!     Render::new(&scene)
//!         .frame(15)
//!         .size(640, 360)
//!         .samples(16)
//!         .progress(|done| eprint!("\r{:3.0} %", done * 100.0))
//!         .save("table.png")
//! }
//! ```
//!
//! A picture depends only on the scene, the frame, the settings and the version of slo-rt: any
//! number of threads, on any machine, makes the same bytes.
//!
//! | to | use |
//! |---|---|
//! | open a scene, or build one in memory | [`Scene`], [`description`] |
//! | render one frame, watch and cancel it | [`Render`] |
//! | read pixels, save PNG or EXR with the recipe | [`Picture`] |
//! | trace rays without a scene | the crate `slo-accel` |
//! | run the program | [`cli`] |
//!
//! [`Scene`], [`Render`], [`Picture`], [`Error`] and [`description`] are the library. The crates
//! `slo-scene`, `slo-picture` and `slo-render` below them are its parts, and may change with any
//! version.

pub mod cli;
mod error;
mod gpu;
mod picture;
mod render;
mod scene;

/// Contents of a scene as plain data, for programs that build scenes in memory.
///
/// Any version may add kinds of shapes, materials and lights. Matches on them must name all kinds:
/// that is how slo-rt itself notices what a new kind needs. Settings start from their defaults.
pub mod description {
    pub use glam;
    pub use slo_scene::animation::View;
    pub use slo_scene::settings::{
        Accelerator, Contrast, Curve, Encoding, Film, Filter, Generator, Integrator, Layer,
        LightSampling, Look, OutputFormat, Settings, ShadowMode, ToneMap, Wrap,
    };
    pub use slo_scene::{
        CamSegment, Camera, Copy, KeyFrame, Light, LightKind, LightMap, Material, MaterialId,
        MaterialKind, Mesh, Object, Original, Placement, Placements, SceneDescription, Shape,
        Space, SpaceId, Texture, TextureId, TextureUse,
    };
    pub use slo_scene::{light, material, mesh, shape, texture};
}

pub use error::Error;
pub use picture::Picture;
pub use render::Render;
pub use scene::Scene;
pub use slo_render::frame::FrameError;
pub use slo_scene::diagnostics::Diagnostics;
pub use slo_scene::{Layer, OutputFormat};
