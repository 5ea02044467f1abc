//! The scene during one shutter: everything that a frame needs, immutable and shared by all
//! threads.

mod affine;
mod baked;
mod bend;
mod build;
mod compositing;
mod crowd;
mod emitters;
mod error;
mod first_hits;
mod glow;
mod instance;
mod kept;
mod lamps;
mod lists;
mod looks;
mod members;
mod parts;
mod remains;
mod sampled;
mod sampled_camera;
mod sampled_motion;
mod scene;
mod shapes;
mod shared;
mod sharp;
mod sharpness;
mod shown;
mod surfaces;
mod survey;
mod texel_points;
mod texels;
mod things;
mod world;

pub use error::FrameError;
pub use kept::Aids;
pub use lamps::LampFault;
pub(crate) use looks::Look;
pub use remains::Remains;
pub use scene::FrameScene;
pub(crate) use surfaces::{NO_MATERIAL, SurfaceScratch, Surfaces};
pub(crate) use texels::{Baked, TexelPoint};
pub use things::{Thing, Things};
pub(crate) use world::{WorldHits, WorldScratch};
