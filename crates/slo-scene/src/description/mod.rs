//! The resolved scene: references followed, units scaled, defaults filled in, files loaded.
//!
//! Everything is plain data in scene space: right-handed, f64, the user's own units (`Scaling`
//! already applied). Nothing here knows a frame number, a ray or a thread.

mod camera;
mod check;
mod copies;
mod layer_names;
mod light_groups;
mod object;
mod space;

use std::sync::Arc;

use crate::light::Light;
use crate::material::Material;
use crate::settings::Settings;
use crate::texture::Texture;

pub use crate::key_frame::{KeyFrame, Placement, SpaceId};
pub use crate::material::MaterialId;
pub use camera::{CamSegment, Camera};
pub use copies::{Copy, MOST_COPIED, MOST_NESTED, MOST_SHOWN, Original};
pub use layer_names::{LayerNames, MaskNames};
pub use light_groups::LightGroups;
pub use object::Object;
pub use space::Space;

/// A scene that has no errors: all that its text, meshes and textures say.
#[derive(Clone, Debug)]
pub struct SceneDescription {
    /// How to render.
    pub settings: Settings,
    /// The one camera.
    pub camera: Camera,
    /// Lights in the order of the text.
    pub lights: Vec<Light>,
    /// Materials in the order of the text.
    pub materials: Vec<Material>,
    /// Images that materials refer to.
    pub textures: Vec<Arc<Texture>>,
    /// Objects in the order of the text.
    pub objects: Vec<Object>,
    /// What objects, lights and other spaces hang in.
    pub spaces: Vec<Space>,
    /// Other places for objects, lights, and all that hangs in a space.
    pub copies: Vec<Copy>,
    /// BLAKE3 over everything that can change a picture of this scene: the text and the bytes of
    /// every mesh and texture, in the order of their loading.
    pub content_hash: [u8; 32],
}
