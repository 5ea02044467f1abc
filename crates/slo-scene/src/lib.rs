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
pub mod settings;
pub mod texture;

pub use description::{
    CamSegment, Camera, KeyFrame, Light, LightShape, Material, MaterialId, Mesh, Object, Placement,
    SceneDescription, Shape, TextureId, TextureUse,
};
pub use files::Files;
pub use load::{Loaded, load};
pub use settings::{
    Accelerator, Contrast, Encoding, Film, Generator, Layer, LightSampling, MOST_CAMERA_SAMPLES,
    OutputFormat, Settings, ShadowMode,
};
pub use texture::Texture;
