//! The light maps that `PHOTON_MAP` makes of photons, and reads where rays that gather light end.

use glam::Vec3;

use super::scene::FrameScene;
use super::texels::Texels;
use super::world::WorldHits;
use slo_scene::{Integrator, SceneDescription};

/// Means that an object has no light map.
const NONE: u32 = u32::MAX;

/// The light maps of a frame.
#[derive(Debug, Default)]
pub(crate) struct LightMaps {
    all: Vec<Texels>,
    /// For each object, the index of its light map, or [`NONE`]; empty if there are none.
    of_objects: Vec<u32>,
}

impl LightMaps {
    /// The light maps of all objects that have one, if the frame gathers light.
    pub(super) fn of(frame: &FrameScene, scene: &SceneDescription) -> Self {
        if frame.settings.integrator != Integrator::PhotonMap || !frame.settings.gather {
            return Self::default();
        }
        let texels = (0..)
            .zip(&scene.objects)
            .filter_map(|(number, object)| frame.texels(scene, number, object.light_map?));
        let all: Vec<Texels> = texels.collect();
        let mut of_objects = Vec::new();
        if !all.is_empty() {
            of_objects.resize(frame.objects.len(), NONE);
            for (number, texels) in (0..).zip(&all) {
                of_objects[texels.object() as usize] = number;
            }
        }
        Self { all, of_objects }
    }

    /// The texels of all light maps.
    pub(crate) fn all(&self) -> &[Texels] {
        &self.all
    }
}

impl FrameScene {
    /// Returns the points in the middle of all texels of a light map, row by row, with their normals, in
    /// the middle of the shutter.
    pub(crate) fn texel_middles(&self, texels: &Texels) -> Vec<Option<[Vec3; 2]>> {
        let side = texels.side();
        let point = |place| {
            let found = self.texel_point(texels, place, [0.5; 2], 0.5)?;
            Some([found.point, found.normal])
        };
        (0..side).flat_map(|y| (0..side).map(move |x| [x, y])).map(point).collect()
    }

    /// Returns the light map of the object that a ray hit, and the index of its texel, if there is one on
    /// that side of the surface. The hit is at a point, at a time of the shutter.
    pub(crate) fn texel_of(
        &self,
        found: &WorldHits,
        ray: usize,
        (point, time, from_outside): (Vec3, f32, bool),
    ) -> Option<(usize, usize)> {
        let object = self.object_of(found.hits.primitive[ray], found.instance[ray]);
        let map = *self.light_maps.of_objects.get(object as usize)?;
        let texels = self.light_maps.all.get(map as usize)?;
        Some((map as usize, texels.at(self.uv_of(found, ray, point, time), from_outside)?))
    }
}
