//! The scene language of slo-rt: text, meshes and images become a [`SceneDescription`].
//!
//! ```text
//! text --format--> syntax tree --resolve, with meshes and textures--> SceneDescription --animation--> where things are at a time
//! ```
//!
//! Everything is plain data in scene space: right-handed, f64, in the user's own units. Nothing here
//! knows a ray.

pub mod animation;
mod assets;
mod attributes;
pub mod cache;
mod description;
pub mod diagnostics;
pub mod edit;
mod file_kinds;
pub mod files;
pub mod format;
mod key_frame;
mod kinds;
mod known_files;
pub mod light;
pub mod light_map;
mod load;
pub mod material;
pub mod memory;
pub mod mesh;
mod mesh_shapes;
mod names;
mod placements;
mod resolve;
mod scene_text;
pub mod settings;
pub mod shape;
pub mod texture;

pub use description::{
    CamSegment, Camera, Copy, KeyFrame, LayerNames, LightGroups, MOST_COPIED, MOST_NESTED,
    MOST_SHOWN, MaskNames, MaterialId, Object, Original, Placement, SceneDescription, Space,
    SpaceId,
};
pub use files::Files;
pub use known_files::KnownFiles;
pub use light::{Light, LightKind};
pub use light_map::LightMap;
pub use load::{Loaded, load, load_adapted};
pub use material::{Channel, ImageUse, Material, MaterialKind, TextureId, TextureUse};
pub use mesh::Mesh;
pub use mesh_shapes::{MeshShapes, ShapeAt, ShapeError};
pub use placements::Placements;
pub use settings::{
    Accelerator, CausticFilter, Contrast, Curve, Encoding, Film, Filter, Generator, Integrator,
    Layer, LightSampling, Look, MOST_CAMERA_SAMPLES, OutputFormat, PhotonSeed, Repeat, Settings,
    ShadowMode, ToneMap, Wrap,
};
pub use shape::Shape;
pub use texture::Texture;
