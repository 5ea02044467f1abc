//! Materials of the model.

use std::collections::HashMap;

use glam::DVec3;

use super::state::{Materials, State};
use crate::model::{ImageUse, Material, Model};

/// Exponent of the sharpest highlights.
const SHARPEST: f64 = 128.0;

/// Steps of a colour that is the mean of several.
const STEPS: f64 = 31.0;

/// Materials by what they say.
#[derive(Debug, Default)]
pub(super) struct Looks {
    known: HashMap<String, usize>,
}

/// A material of a list.
#[derive(Clone, Copy, Debug)]
struct Look {
    /// Ambient, diffuse, specular, emissive.
    colors: [DVec3; 4],
    shininess: f64,
    transparency: f64,
}

impl Looks {
    /// The material of these numbers of the list, or the mean of several.
    pub(super) fn material(
        &mut self,
        numbers: &[usize],
        state: &State,
        model: &mut Model,
    ) -> usize {
        let first = Look::of(&state.materials, numbers[0]);
        let is_one = numbers.iter().all(|&number| number == numbers[0]);
        let look = if is_one { first } else { Look::mean(&state.materials, numbers) };
        let material = look.material(state);
        let image = state.texture.map(|t| (t.image, t.clamps));
        let key = format!("{:?} {:?} {image:?}", material.colors, material.numbers);
        *self.known.entry(key).or_insert_with(|| {
            model.materials.push(material);
            model.materials.len() - 1
        })
    }
}

impl Look {
    /// Lists that are too short go on with their last entry.
    fn of(materials: &Materials, number: usize) -> Self {
        let color = |list: &[DVec3]| list.get(number).or(list.last()).copied().unwrap_or_default();
        let value = |list: &[f64]| list.get(number).or(list.last()).copied().unwrap_or_default();
        let Materials { ambient, diffuse, specular, emissive, shininess, transparency } = materials;
        Self {
            colors: [ambient, diffuse, specular, emissive].map(|list| color(list)),
            shininess: value(shininess),
            transparency: value(transparency),
        }
    }

    /// The mean, in steps, so that there are not as many materials as faces.
    fn mean(materials: &Materials, numbers: &[usize]) -> Self {
        let mut mean = Self::of(materials, numbers[0]);
        for &number in &numbers[1..] {
            let other = Self::of(materials, number);
            mean.colors.iter_mut().zip(other.colors).for_each(|(sum, color)| *sum += color);
            mean.transparency += other.transparency;
        }
        let count = numbers.len() as f64;
        let stepped = |value: f64| (value / count * STEPS).round() / STEPS;
        mean.colors = mean.colors.map(|sum| (sum / count * STEPS).round() / STEPS);
        mean.transparency = stepped(mean.transparency);
        mean
    }

    fn material(&self, state: &State) -> Material {
        let [ambient, mut diffuse, specular, emissive] =
            self.colors.map(|color| color.clamp(DVec3::ZERO, DVec3::ONE));
        let transparency = self.transparency.clamp(0.0, 1.0);
        if state.texture.is_some_and(|texture| texture.replaces) {
            diffuse = DVec3::ONE;
        }
        // What is not lit shows its colour.
        let (own, diffuse, specular) = if state.is_unlit {
            (diffuse, DVec3::ZERO, DVec3::ZERO)
        } else {
            (ambient * state.everywhere + emissive, diffuse, specular)
        };
        let mut material = Material { name: "material".into(), ..Material::default() };
        for (input, color) in [("ambient", own), ("diffuse", diffuse), ("specular", specular)] {
            let color = color * (1.0 - transparency);
            if color != DVec3::ZERO {
                material.colors.push((input, color.to_array()));
            }
        }
        if specular != DVec3::ZERO {
            material.numbers.push(("shininess", SHARPEST * self.shininess.clamp(0.0, 1.0)));
        }
        if transparency > 0.0 {
            material.numbers.push(("refraction", transparency));
        }
        if let Some(texture) = state.texture {
            let wrap = if texture.clamps { "CLAMP" } else { "REPEAT" };
            material.images.push(("diffuse", ImageUse { wrap, ..ImageUse::of(texture.image) }));
        }
        material
    }
}
