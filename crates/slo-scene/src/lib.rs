//! The scene language of slo-rt: text, meshes and images become a [`SceneDescription`].
//!
//! ```text
//! text --format--> syntax tree --resolve, with meshes and textures--> SceneDescription --animation--> where things are when
//! ```
//!
//! Everything is plain data in scene space: right-handed, f64, in the user's own units. Nothing here
//! knows a ray or a thread.

pub mod animation;
mod description;
pub mod diagnostics;
pub mod files;
pub mod format;
mod kinds;
mod load;
pub mod mesh;
mod names;
mod resolve;
pub mod texture;

pub use description::{
    Accelerator, CamSegment, Camera, Contrast, Encoding, Film, Generator, KeyFrame, Layer, Light,
    LightSampling, LightShape, MOST_CAMERA_SAMPLES, Material, MaterialId, Mesh, Object,
    OutputFormat, Placement, SceneDescription, Settings, ShadowMode, Shape, TextureId, TextureUse,
};
pub use files::Files;
pub use load::{Loaded, load};
pub use texture::Texture;
