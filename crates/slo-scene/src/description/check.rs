//! Whether a scene that was built in memory holds together.

use super::{Object, SceneDescription};
use crate::light::{Environment, Light, LightKind, Sky};
use crate::material::Material;

impl SceneDescription {
    /// Checks that every reference and index leads somewhere, and that there is a camera to look
    /// through. Scenes that were read from text always pass.
    ///
    /// # Errors
    /// The first fault, in words.
    pub fn check(&self) -> Result<(), String> {
        if self.camera.segments.is_empty() {
            return Err("the camera has no segment".into());
        }
        if !(self.camera.fps > 0.0 && self.camera.fps.is_finite()) {
            return Err(format!("the camera has {} frames per second", self.camera.fps));
        }
        for segment in &self.camera.segments {
            if segment.positions.is_empty() || segment.targets.is_empty() {
                return Err(format!("camera segment `{}` has no path", segment.name));
            }
        }
        self.lights.iter().try_for_each(|light| self.check_light(light))?;
        self.materials.iter().try_for_each(|material| self.check_material(material))?;
        self.objects.iter().try_for_each(|object| self.check_object(object))
    }

    fn check_light(&self, light: &Light) -> Result<(), String> {
        let name = &light.name;
        if let LightKind::Environment(Environment { sky: Sky::Image(texture), .. }) = light.kind
            && texture.0 as usize >= self.textures.len()
        {
            return Err(format!("environment `{name}` refers to a texture that is missing"));
        }
        Ok(())
    }

    fn check_material(&self, material: &Material) -> Result<(), String> {
        match material.kind.image() {
            Some(texture) if texture.0 as usize >= self.textures.len() => {
                Err(format!("material `{}` refers to a texture that is missing", material.name))
            }
            _ => Ok(()),
        }
    }

    fn check_object(&self, object: &Object) -> Result<(), String> {
        let name = &object.name;
        if object.material.0 as usize >= self.materials.len() {
            return Err(format!("`{name}` refers to a material that is missing"));
        }
        if !object.shape.is_consistent() {
            return Err(format!("an index of `{name}` leads nowhere"));
        }
        Ok(())
    }
}
