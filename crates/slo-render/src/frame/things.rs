//! What the objects and lights of a frame are in the scene.

use glam::Vec3;

use super::error::FrameError;
use super::looks::Look;
use super::scene::FrameScene;
use super::shown::{Shown, ShownObject};
use slo_scene::SceneDescription;

/// Names of the objects and lights of a frame, by their numbers.
#[derive(Clone, Debug)]
pub struct Things {
    /// Objects, and lamps that rays can hit.
    pub objects: Vec<Thing>,
    /// Lights: lamps, skies, and triangles and spheres of objects that emit light.
    pub lights: Vec<String>,
}

/// An object of a frame, or a lamp that rays can hit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Thing {
    /// Its name in the scene; copies have the name of their original.
    pub name: String,
    /// Name of its material; `None` for lamps.
    pub material: Option<String>,
}

impl FrameScene {
    /// Returns the names of all objects and lights of the frame, which must be one of `scene`.
    ///
    /// # Errors
    /// None that building the frame did not report.
    pub fn things(&self, scene: &SceneDescription) -> Result<Things, FrameError> {
        let shown = Shown::of(scene)?;
        let count = self.looks.len();
        let casts = count - shown.casts.len().min(count);
        let light_name = |light: u32| shown.lights.get(light as usize).map(|of| &*of.light.name);
        let thing = |number: usize| match self.looks.of(number as u32) {
            Look::Light(light) => {
                let name = light_name(light).unwrap_or_default().to_owned();
                Thing { name, material: None }
            }
            Look::Nothing => Thing { name: String::new(), material: None },
            Look::Material(material) => {
                let object = match shown.objects.get(number) {
                    Some(ShownObject { object, .. }) => *object,
                    None => &scene.objects[shown.casts[number - casts].0 as usize],
                };
                let material = Some(scene.materials[material as usize].name.clone());
                Thing { name: object.name.clone(), material }
            }
        };
        let objects: Vec<Thing> = (0..count).map(thing).collect();
        let mut emitters: Vec<(u32, &str)> = Vec::new();
        for (object, thing) in self.objects.iter().zip(&objects) {
            emitters.extend(object.first_light.map(|first| (first, &*thing.name)));
        }
        emitters.sort_unstable();
        let light = |number: u32| {
            let emitter = emitters.partition_point(|(first, _)| *first <= number);
            let emitter = emitter.checked_sub(1).map(|place| emitters[place].1);
            light_name(number).or(emitter).unwrap_or("background").to_owned()
        };
        let lights = (0..self.lights.len() as u32).map(light).collect();
        Ok(Things { objects, lights })
    }

    /// Returns the lights that a ray sees at a shutter time if it hits nothing: suns and skies that may
    /// shine from there.
    pub fn skies_seen(&self, time: f32, from: Vec3, way: Vec3) -> Vec<u32> {
        let shines = |light: &u32| self.lights.density(*light, time, from, way) > 0.0;
        self.skies.iter().copied().filter(shines).collect()
    }

    /// Returns a point of render space in scene space.
    pub fn scene_point(&self, point: Vec3) -> [f64; 3] {
        (point.as_dvec3() + self.compositing.origin).to_array()
    }
}
