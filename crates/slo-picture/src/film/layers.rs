//! Layers of a picture: what its file holds beside the colours.

use slo_scene::{Layer, LightGroups};

use super::area::Area;
use super::features::Features;
use super::grid::Film;
use super::image::Image;

/// A layer of a picture's file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FileLayer {
    /// See [`Layer::Albedo`].
    Albedo,
    /// See [`Layer::Normal`].
    Normal,
    /// The light of a group, by the group's name.
    Light(String),
}

impl FileLayer {
    /// The layers of a file that has these, in its order, if the scene has these groups of lights.
    pub fn all(layers: &[Layer], groups: &LightGroups) -> Vec<Self> {
        let of = |layer: &Layer| match layer {
            Layer::Albedo => vec![Self::Albedo],
            Layer::Normal => vec![Self::Normal],
            Layer::Lights => {
                let names = groups.names().iter().map(String::as_str);
                names.chain([LightGroups::REST]).map(|name| Self::Light(name.to_owned())).collect()
            }
        };
        layers.iter().flat_map(of).collect()
    }

    /// The name: what channels of the layer begin with.
    pub fn name(&self) -> String {
        match self {
            Self::Albedo => Layer::Albedo.name().to_owned(),
            Self::Normal => Layer::Normal.name().to_owned(),
            Self::Light(group) => format!("{}.{group}", Layer::Lights.name()),
        }
    }
}

impl Film {
    /// A layer of an area inside this film's; black without such a layer.
    pub fn layer_of(&self, area: Area, layer: &FileLayer) -> Image {
        let mut rgb = Vec::with_capacity(area.len());
        rgb.extend(self.rows(area).flatten().map(|i| self.layer_at(layer, i)));
        Image { width: area.width(), height: area.height(), rgb }
    }

    /// Some layers of an area inside this film's.
    pub fn layers_of(&self, area: Area, layers: Vec<FileLayer>) -> Vec<(FileLayer, Image)> {
        let with_image = |layer| {
            let image = self.layer_of(area, &layer);
            (layer, image)
        };
        layers.into_iter().map(with_image).collect()
    }

    /// Adds what layers need, unexposed, if the scene has these groups of lights.
    ///
    /// # Errors
    /// [`TooLarge`](super::TooLarge) if there is not enough memory.
    pub fn with_layers(
        self,
        layers: &[Layer],
        groups: &LightGroups,
    ) -> Result<Self, super::TooLarge> {
        let has_surfaces = layers.iter().any(|layer| layer.is_of_surfaces());
        let film = if has_surfaces { self.with_features()? } else { self };
        let has_lights = layers.contains(&Layer::Lights);
        if has_lights { film.with_light_groups(groups.clone()) } else { Ok(film) }
    }

    /// A layer of the pixel of row-major index `i`; black without such a layer.
    pub(super) fn layer_at(&self, layer: &FileLayer, i: usize) -> [f32; 3] {
        let samples = self.pixels[i].samples;
        let surfaces = |mean: fn(&Features, u32) -> [f32; 3]| {
            self.features.get(i).map_or([0.0; 3], |features| mean(features, samples))
        };
        match layer {
            FileLayer::Albedo => surfaces(Features::mean_albedo),
            FileLayer::Normal => surfaces(Features::mean_normal),
            FileLayer::Light(group) => self.light_at(group, i),
        }
    }

    /// Mean light of a group in a pixel.
    fn light_at(&self, group: &str, i: usize) -> [f32; 3] {
        let Some(groups) = self.light_groups() else { return [0.0; 3] };
        let (lights, pixel) = (self.lights(i), &self.pixels[i]);
        let rest = |c: usize| lights.iter().fold(pixel.sum[c], |rest, light| rest.less(light[c]));
        let sum = match groups.index(Some(group)) {
            Some(index) => lights[index],
            None if group == LightGroups::REST => [0, 1, 2].map(rest),
            None => return [0.0; 3],
        };
        let samples = f64::from(pixel.samples.max(1));
        sum.map(|sum| (sum.to_f64() / samples) as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::super::area::Area;
    use super::super::fixed::Fixed;
    use super::*;

    #[test]
    fn files_have_a_layer_for_each_group() {
        let groups = LightGroups::new(["key", "fill"]);
        let names = |layers: &[Layer], groups: &LightGroups| {
            FileLayer::all(layers, groups).iter().map(FileLayer::name).collect::<Vec<_>>()
        };
        let expected = ["albedo", "normal", "lights.fill", "lights.key", "lights.rest"];
        assert_eq!(names(&Layer::ALL, &groups), expected);
        assert_eq!(names(&[Layer::Lights], &LightGroups::default()), ["lights.rest"]);
        assert_eq!(names(&[], &groups), Vec::<String>::new());
    }

    #[test]
    fn groups_and_the_rest_add_up_to_the_picture() {
        let groups = LightGroups::new(["a", "b"]);
        let film = Film::new(Area::whole(2, 1), false).unwrap();
        let mut film = film.with_layers(&[Layer::Lights], &groups).unwrap();
        let gray = |value: f32| [Fixed::new(value).unwrap(); 3];
        for i in 0..2 {
            film.at_mut(i).0.add(gray(7.0), 2);
            film.lights_mut(i).copy_from_slice(&[gray(1.0), gray(i as f32 * 4.0)]);
        }
        let at = |name: &str, i| film.layer_at(&FileLayer::Light(name.into()), i);
        assert_eq!([at("a", 0), at("b", 0), at("rest", 0)], [0.5, 0.0, 3.0].map(|x| [x; 3]));
        assert_eq!([at("a", 1), at("b", 1), at("rest", 1)], [0.5, 2.0, 1.0].map(|x| [x; 3]));
        assert_eq!((at("c", 0), film.layer_at(&FileLayer::Albedo, 0)), ([0.0; 3], [0.0; 3]));
        let plain = Film::new(Area::whole(2, 1), false).unwrap();
        assert_eq!(plain.layer_at(&FileLayer::Light("rest".into()), 0), [0.0; 3]);
    }
}
