//! The scene during one shutter: everything that a frame needs, immutable and shared by all
//! threads.

mod build;
mod compositing;
mod emitters;
mod error;
mod first_hits;
mod glow;
mod looks;
mod parts;
mod rigid;
mod sampled;
mod sampled_camera;
mod sampled_motion;
mod scene;
mod shapes;
mod sharp;
mod surfaces;
mod world;

pub use error::FrameError;
pub(crate) use looks::Look;
pub use scene::FrameScene;
pub(crate) use surfaces::{NO_MATERIAL, SurfaceScratch, Surfaces};
pub(crate) use world::{WorldHits, WorldScratch};
