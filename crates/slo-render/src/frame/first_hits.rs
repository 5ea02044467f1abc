//! What layers for compositors show of the first hits of camera rays.

use glam::Vec3;

use super::compositing::Compositing;
use super::scene::FrameScene;
use super::world::WorldHits;
use slo_picture::film::{Place, PlaceLayers};

impl FrameScene {
    /// Returns what layers show of a hit of a camera ray at `point`, in render space.
    pub(crate) fn place_of(
        &self,
        layers: PlaceLayers,
        (found, ray): (&WorldHits, usize),
        point: Vec3,
        time: f32,
    ) -> Place {
        let scene_point = |point: Vec3| point.as_dvec3() + self.compositing.origin;
        let mut place = Place::default();
        if layers.depth {
            place.depth = self.camera.depth(time, point).into();
        }
        if layers.position {
            place.position = scene_point(point).to_array();
        }
        let (primitive, instance) = (found.hits.primitive[ray], found.instance[ray]);
        if layers.uv && self.look_of(primitive, instance).material().is_some() {
            place.uv = Some(self.uv_of(found, ray, point, time).map(f64::from));
        }
        if layers.motion {
            let opening = scene_point(self.moved(instance, point, [time, 0.0]));
            place.motion = self.compositing.motion(self.object_of(primitive, instance), opening);
        }
        place
    }

    /// Returns the ids of the object that a ray hit and of its material; 0: none.
    pub(crate) fn mask_ids(&self, found: &WorldHits, ray: usize) -> [u32; 2] {
        let object = self.object_of(found.hits.primitive[ray], found.instance[ray]) as usize;
        let Compositing { objects, materials, .. } = &self.compositing;
        [objects, materials].map(|ids| ids.get(object).copied().unwrap_or(0))
    }
}
