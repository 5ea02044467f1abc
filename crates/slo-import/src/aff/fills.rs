//! Fills: what shapes are made of.

use std::collections::HashMap;

use glam::DVec3;

use crate::error::ImportError;
use crate::model::{ImageUse, Material, Model};
use crate::words::Words;

/// The fill that shapes get, and what fills became.
#[derive(Debug, Default)]
pub(super) struct Fills {
    /// Fills that differ.
    all: Vec<Material>,
    /// Numbers of these fills, by what they say.
    known: HashMap<Vec<u64>, usize>,
    current: Option<usize>,
    /// Materials of the model, by fills and images.
    materials: HashMap<(usize, Option<usize>), usize>,
}

impl Fills {
    /// Reads `f`: a colour and factors.
    pub(super) fn plain(&mut self, words: &mut Words<'_>) -> Result<(), ImportError> {
        let color = words.vector()?.max(DVec3::ZERO);
        let [diffuse, specular] = [words.number()?.max(0.0), words.number()?.max(0.0)];
        let colors = [DVec3::ZERO, color * diffuse, DVec3::splat(specular)];
        self.rest(words, colors, specular)
    }

    /// Reads `fm`: three colours. Mirrors have a number only, the mean of theirs.
    pub(super) fn colors(
        &mut self,
        words: &mut Words<'_>,
        model: &mut Model,
    ) -> Result<(), ImportError> {
        let mut color = || words.vector().map(|color| color.max(DVec3::ZERO));
        let colors = [color()?, color()?, color()?];
        let (mirror, count) = (colors[2].element_sum() / 3.0, self.all.len());
        self.rest(words, colors, mirror)?;
        let is_new = self.all.len() > count;
        if is_new && (colors[2] - mirror).abs().max_element() > 1e-3 {
            model.notes.leave_out("the colour of a mirror");
        }
        Ok(())
    }

    fn rest(
        &mut self,
        words: &mut Words<'_>,
        [ambient, diffuse, specular]: [DVec3; 3],
        mirror: f64,
    ) -> Result<(), ImportError> {
        let mut number = || words.number().map(|number| number.max(0.0));
        let [shine, transmission, ior] = [number()?, number()?, number()?];
        let mut fill = Material { name: "fill".into(), ..Material::default() };
        if ambient != DVec3::ZERO {
            fill.colors.push(("ambient", ambient.to_array()));
        }
        fill.colors.push(("diffuse", diffuse.to_array()));
        if specular != DVec3::ZERO {
            fill.colors.push(("specular", specular.to_array()));
            fill.numbers.push(("shininess", shine));
            fill.numbers.push(("reflectance", mirror));
        }
        if transmission > 0.0 {
            fill.numbers.push(("refraction", transmission));
            fill.numbers.push(("refraction_index", if ior > 0.0 { ior } else { 1.0 }));
        }
        self.set(fill);
        Ok(())
    }

    /// Makes a fill the current one. Files repeat fills, so equal ones are one.
    fn set(&mut self, fill: Material) {
        let colors = fill.colors.iter().flat_map(|(_, color)| color);
        let numbers = colors.chain(fill.numbers.iter().map(|(_, number)| number));
        let key = [fill.colors.len() as u64].into_iter().chain(numbers.map(|n| n.to_bits()));
        self.current = Some(*self.known.entry(key.collect()).or_insert_with(|| {
            self.all.push(fill);
            self.all.len() - 1
        }));
    }

    /// The material of the current fill, which is white before the first, with an image.
    pub(super) fn material(&mut self, image: Option<usize>, model: &mut Model) -> usize {
        if self.current.is_none() {
            let colors = vec![("diffuse", [1.0; 3])];
            self.set(Material { name: "fill".into(), colors, ..Material::default() });
        }
        let fill = self.current.unwrap_or_default();
        *self.materials.entry((fill, image)).or_insert_with(|| {
            let Material { name, colors, numbers, .. } = &self.all[fill];
            let mut material = Material {
                name: name.clone(),
                colors: colors.clone(),
                numbers: numbers.clone(),
                images: Vec::new(),
            };
            if let Some(image) = image {
                let file = &model.images[image].name;
                material.name =
                    file.rsplit_once('.').map_or(file.as_str(), |(stem, _)| stem).into();
                material.images.push(("diffuse", ImageUse::of(image)));
            }
            model.materials.push(material);
            model.materials.len() - 1
        })
    }
}

/// Multiplies what materials give off by the light that is everywhere.
pub(super) fn light_from_everywhere(model: &mut Model, color: DVec3) {
    for material in &mut model.materials {
        for (input, ambient) in &mut material.colors {
            if *input == "ambient" {
                *ambient = (DVec3::from(*ambient) * color).to_array();
            }
        }
        material.colors.retain(|(input, color)| *input != "ambient" || *color != [0.0; 3]);
    }
}
