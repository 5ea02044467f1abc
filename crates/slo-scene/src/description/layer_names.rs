//! Names of what layers of a picture show.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::{LightGroups, SceneDescription};
use crate::settings::Layer;

/// Names of what layers of a picture show; empty if the picture has no such layer.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LayerNames {
    /// Of [`Layer::Lights`].
    pub lights: LightGroups,
    /// Of [`Layer::CryptoObject`].
    pub objects: MaskNames,
    /// Of [`Layer::CryptoMaterial`].
    pub materials: MaskNames,
}

/// Names in their order, each once.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MaskNames(Arc<[String]>);

impl MaskNames {
    /// These names, in any order.
    pub fn new<'a>(names: impl IntoIterator<Item = &'a str>) -> Self {
        let names: BTreeSet<&str> = names.into_iter().collect();
        Self(names.into_iter().map(str::to_owned).collect())
    }

    /// The names in their order.
    pub fn names(&self) -> &[String] {
        &self.0
    }
}

impl SceneDescription {
    /// The names of what the layers of its film show.
    pub fn layer_names(&self) -> LayerNames {
        let has = |layer| self.camera.film.layers.contains(&layer);
        let mut names = LayerNames { lights: self.light_groups(), ..LayerNames::default() };
        if has(Layer::CryptoObject) {
            let lights = self.lights.iter().map(|light| &*light.name);
            let objects = self.objects.iter().map(|object| &*object.name);
            names.objects = MaskNames::new(objects.chain(lights));
        }
        if has(Layer::CryptoMaterial) {
            let used = self.objects.iter().map(|object| object.material.0 as usize);
            let used: BTreeSet<usize> = used.collect();
            names.materials = MaskNames::new(used.iter().map(|&i| &*self.materials[i].name));
        }
        names
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_have_an_order_of_their_own() {
        let names = MaskNames::new(["b", "a", "b"]);
        assert_eq!(names.names(), ["a", "b"]);
        assert_eq!(names, MaskNames::new(["a", "b"]));
    }
}
