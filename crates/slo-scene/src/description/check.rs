//! Whether a scene that was built in memory holds together.

use super::{Copy, MaterialId, Object, Original, SceneDescription, SpaceId};
use crate::light::{Environment, Light, LightKind, Sky};
use crate::material::{MOST_MIXES, Material, Tangle, inside_out};

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
        self.check_spaces()?;
        self.lights.iter().try_for_each(|light| self.check_light(light))?;
        self.materials.iter().try_for_each(|material| self.check_material(material))?;
        inside_out(&self.materials).map_err(|tangle| self.tangled(&tangle))?;
        self.copies.iter().try_for_each(|copy| self.check_copy(copy))?;
        self.objects.iter().try_for_each(|object| self.check_object(object))
    }

    /// Whether what hangs in a space is left out of the picture.
    pub fn hides(&self, parent: Option<SpaceId>) -> bool {
        let above = |id: &SpaceId| self.spaces.get(id.0 as usize)?.parent;
        let spaces = std::iter::successors(parent, above).take(self.spaces.len());
        spaces.into_iter().any(|id| self.spaces.get(id.0 as usize).is_some_and(|of| of.hidden))
    }

    fn check_copy(&self, copy: &Copy) -> Result<(), String> {
        let name = &copy.name;
        let is_there = |original: &Original| match *original {
            Original::Object(index) => (index as usize) < self.objects.len(),
            Original::Light(index) => (index as usize) < self.lights.len(),
            Original::Group(space) => (space.0 as usize) < self.spaces.len(),
            Original::Copy(index) => (index as usize) < self.copies.len(),
        };
        if !copy.of.iter().all(is_there) {
            return Err(format!("`{name}` is a copy of what is missing"));
        }
        if copy.material.is_some_and(|id| id.0 as usize >= self.materials.len()) {
            return Err(format!("`{name}` refers to a material that is missing"));
        }
        let kinds = copy.placements.iter().flat_map(|placements| &placements.kinds);
        if let Some(kind) = kinds.into_iter().find(|kind| **kind as usize >= copy.of.len()) {
            return Err(format!("`{name}` has no original of kind {kind}"));
        }
        self.check_parent(name, copy.parent)
    }

    fn check_spaces(&self) -> Result<(), String> {
        for space in &self.spaces {
            self.check_parent(&space.name, space.parent)?;
        }
        let mut is_sound = vec![false; self.spaces.len()];
        for (start, space) in self.spaces.iter().enumerate() {
            let mut way = vec![start];
            let mut at = start;
            while let (Some(parent), false) = (self.spaces[at].parent, is_sound[at]) {
                at = parent.0 as usize;
                way.push(at);
                if way.len() > self.spaces.len() {
                    return Err(format!("`{}` hangs in itself, or in what does", space.name));
                }
            }
            way.into_iter().for_each(|number| is_sound[number] = true);
        }
        Ok(())
    }

    fn check_parent(&self, name: &str, parent: Option<SpaceId>) -> Result<(), String> {
        if parent.is_some_and(|id| id.0 as usize >= self.spaces.len()) {
            return Err(format!("`{name}` refers to a parent that is missing"));
        }
        Ok(())
    }

    fn check_light(&self, light: &Light) -> Result<(), String> {
        let name = &light.name;
        if let LightKind::Environment(Environment { sky: Sky::Image(texture), .. }) = light.kind
            && texture.0 as usize >= self.textures.len()
        {
            return Err(format!("environment `{name}` refers to a texture that is missing"));
        }
        self.check_parent(name, light.parent)
    }

    fn check_material(&self, material: &Material) -> Result<(), String> {
        let name = &material.name;
        let mut has_images = true;
        material.kind.for_images(&mut |id| has_images &= (id.0 as usize) < self.textures.len());
        if !has_images {
            return Err(format!("material `{name}` refers to a texture that is missing"));
        }
        let mut parts = material.kind.parts().into_iter().flatten();
        if parts.any(|part| part.0 as usize >= self.materials.len()) {
            return Err(format!("material `{name}` mixes a material that is missing"));
        }
        Ok(())
    }

    /// What is wrong with materials that contain others.
    fn tangled(&self, tangle: &Tangle) -> String {
        let name = |id: MaterialId| &self.materials[id.0 as usize].name;
        match tangle {
            Tangle::Circle(circle) => format!("material `{}` contains itself", name(circle[0])),
            Tangle::TooDeep(id) => {
                format!("more than {MOST_MIXES} mixes are nested in material `{}`", name(*id))
            }
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
        self.check_parent(name, object.parent)
    }
}
