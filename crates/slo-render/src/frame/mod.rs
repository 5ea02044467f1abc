//! The scene during one shutter: everything that a frame needs, immutable and shared by all
//! threads.

mod affine;
mod bend;
mod build;
mod compositing;
mod emitters;
mod error;
mod first_hits;
mod glow;
mod kept;
mod lamps;
mod looks;
mod parts;
mod remains;
mod sampled;
mod sampled_camera;
mod sampled_motion;
mod scene;
mod shapes;
mod shared;
mod sharp;
mod shown;
mod surfaces;
mod world;

pub use error::FrameError;
pub use kept::Aids;
pub use lamps::LampFault;
pub(crate) use looks::Look;
pub use remains::Remains;
pub use scene::FrameScene;
pub(crate) use surfaces::{NO_MATERIAL, SurfaceScratch, Surfaces};
pub(crate) use world::{WorldHits, WorldScratch};
