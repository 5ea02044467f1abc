//! Objects: their shape, material and motion.

use crate::key_frame::{KeyFrame, SpaceId};
use crate::light_map::LightMap;
use crate::material::MaterialId;
use crate::settings::Repeat;
use crate::shape::Shape;

/// A thing that can be seen.
#[derive(Clone, Debug)]
pub struct Object {
    /// The name in the text.
    pub name: String,
    /// What it is made of.
    pub material: MaterialId,
    /// What it looks like, in object space (the parent's if there are no key frames).
    pub shape: Shape,
    /// In order of time; none: object space is the parent's. One: a placed object, still in its
    /// parent.
    pub key_frames: Vec<KeyFrame>,
    /// What it hangs in; `None`: scene space.
    pub parent: Option<SpaceId>,
    /// How their motion goes on before the first and after the last; `None`: not at all.
    pub repeat: Option<Repeat>,
    /// Whether rays are sent toward it if its material emits light. Otherwise only rays that hit it
    /// find its light.
    pub sampled: bool,
    /// Whether it is left out of the picture. Copies of it are not.
    pub hidden: bool,
    /// `light_group`: the layer that holds the light that its material emits.
    pub light_group: Option<String>,
    /// Its light map, if it has one.
    pub light_map: Option<LightMap>,
}

impl Object {
    /// An object that rests where its shape is.
    pub fn new(name: impl Into<String>, material: MaterialId, shape: Shape) -> Self {
        let (key_frames, light_group) = (Vec::new(), None);
        Self {
            name: name.into(),
            material,
            shape,
            key_frames,
            parent: None,
            repeat: None,
            sampled: true,
            hidden: false,
            light_group,
            light_map: None,
        }
    }
}
