//! What one shutter sees: everything a frame needs, immutable, shared by all threads.

mod build;
mod surface;
mod tessellate;
mod world;

use std::sync::Arc;

use glam::Vec3;

use crate::accel::Structure;
use crate::camera::Camera;
use crate::math::{DRigid, Rigid};
use crate::sampling::Sampler;
use crate::scene::{Settings, Texture};
use crate::shading::{Light, Material};

pub use build::FrameError;
pub(crate) use surface::{Hit, Surface};
use tessellate::Geometry;
pub(crate) use world::{World, WorldHits, WorldScratch};

/// A scene as one shutter sees it.
///
/// Its space is *render space*: scene space moved so that its origin lies near the camera, in f32.
#[derive(Debug)]
pub struct FrameScene {
    pub(crate) camera: Camera,
    pub(crate) world: World,
    pub(crate) materials: Vec<Material>,
    pub(crate) lights: Vec<Light>,
    pub(crate) sampler: Sampler,
    pub(crate) settings: Settings,
    textures: Vec<Arc<Texture>>,
    objects: Vec<FrameObject>,
    /// Where each still object lies: what the still structure was built of.
    still_places: Vec<(u32, DRigid)>,
    /// For each primitive of the still structure its index in `objects`.
    still_objects: Vec<u32>,
}

/// An object, as shading asks for it.
#[derive(Debug)]
struct FrameObject {
    look: Look,
    geometry: Geometry,
    /// `render_from_object` while it is still.
    place: Rigid,
    /// Id of its first triangle in the still structure.
    first_triangle: u32,
}

/// What a surface shows.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Look {
    /// Index of a material.
    Material(u32),
    /// The surface of a light: its radiance, from both sides.
    Light(Vec3),
}

impl FrameScene {
    /// Bytes of the structures and tables of this frame, meshes and textures not counted.
    pub fn memory(&self) -> usize {
        self.world.memory() + self.still_objects.len() * size_of::<u32>()
    }

    /// How many objects move within the shutter.
    pub fn moving_objects(&self) -> usize {
        self.world.instances.len()
    }

    /// How many primitives there are, in all structures.
    pub fn primitives(&self) -> usize {
        let of = |s: &Structure| s.triangle_count() + s.curved().len();
        let moving: usize = self.world.instances.iter().map(|i| of(&i.structure)).sum();
        of(&self.world.still) + moving
    }
}
