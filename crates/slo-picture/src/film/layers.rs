//! Layers of a picture: what its file holds beside the colours.

use slo_scene::{Layer, LayerNames, LightGroups};

use super::area::Area;
use super::features::Features;
use super::first_hits::FirstHitLayers;
use super::grid::Film;
use super::image::Image;
use super::mask::{Mask, MaskKind, RANKS};
use super::memory::TooLarge;

/// The error of a pixel with too few samples to know it.
const UNKNOWN_ERROR: f32 = 1e10;

/// A layer of a picture's file: up to three numbers of a pixel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FileLayer {
    /// See [`Layer::Albedo`].
    Albedo,
    /// See [`Layer::Normal`].
    Normal,
    /// The light of a group, by the group's name.
    Light(String),
    /// See [`Layer::Depth`].
    Depth,
    /// See [`Layer::Position`].
    Position,
    /// See [`Layer::Uv`].
    Uv,
    /// See [`Layer::Motion`]: where things were in the frame before, minus where they are.
    MotionBefore,
    /// See [`Layer::Motion`]: where things are, minus where they will be in the next frame.
    MotionAfter,
    /// The id of a rank, and its share of the samples.
    Rank(Mask, usize),
    /// See [`Layer::Samples`].
    Samples,
    /// See [`Layer::Error`].
    Error,
}

impl FileLayer {
    /// The layers of a file that has these, in its order, if they show these names.
    pub fn all(layers: &[Layer], names: &LayerNames) -> Vec<Self> {
        let ranks = |kind, names| {
            let mask = Mask { kind, names };
            (0..RANKS).map(|rank| Self::Rank(mask.clone(), rank)).collect()
        };
        let of = |layer: &Layer| match layer {
            Layer::Albedo => vec![Self::Albedo],
            Layer::Normal => vec![Self::Normal],
            Layer::Lights => {
                let names = names.lights.names().iter().map(String::as_str);
                names.chain([LightGroups::REST]).map(|name| Self::Light(name.to_owned())).collect()
            }
            Layer::Depth => vec![Self::Depth],
            Layer::Position => vec![Self::Position],
            Layer::Uv => vec![Self::Uv],
            Layer::Motion => vec![Self::MotionBefore, Self::MotionAfter],
            Layer::CryptoObject => ranks(MaskKind::Object, names.objects.clone()),
            Layer::CryptoMaterial => ranks(MaskKind::Material, names.materials.clone()),
            Layer::Samples => vec![Self::Samples],
            Layer::Error => vec![Self::Error],
        };
        layers.iter().flat_map(of).collect()
    }

    /// The name: what channels of the layer begin with.
    pub fn name(&self) -> String {
        let layer = match self {
            Self::Albedo => Layer::Albedo,
            Self::Normal => Layer::Normal,
            Self::Light(group) => return format!("{}.{group}", Layer::Lights.name()),
            Self::Depth => Layer::Depth,
            Self::Position => Layer::Position,
            Self::Uv => Layer::Uv,
            Self::MotionBefore | Self::MotionAfter => Layer::Motion,
            Self::Rank(mask, rank) => {
                // Two ranks are the four channels of a layer.
                return format!("{}{:02}", mask.kind.layer().name(), rank / 2);
            }
            Self::Samples => Layer::Samples,
            Self::Error => Layer::Error,
        };
        layer.name().to_owned()
    }

    /// What the names of its channels end with, number by number.
    pub fn components(&self) -> &'static [&'static str] {
        match self {
            Self::Albedo | Self::Light(_) | Self::Error => &["R", "G", "B"],
            Self::Normal | Self::Position => &["X", "Y", "Z"],
            Self::Depth => &["Z"],
            Self::Uv => &["U", "V", "A"],
            Self::MotionBefore => &["X", "Y"],
            Self::MotionAfter => &["Z", "W"],
            Self::Rank(_, rank) if rank % 2 == 0 => &["R", "G"],
            Self::Rank(..) => &["B", "A"],
            Self::Samples => &["X"],
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

    /// Adds what layers need, unexposed, if they show these names.
    ///
    /// # Errors
    /// [`TooLarge`] if there is not enough memory.
    pub fn with_layers(self, layers: &[Layer], names: &LayerNames) -> Result<Self, TooLarge> {
        let has_surfaces = layers.iter().any(|layer| layer.is_of_surfaces());
        let film = if has_surfaces { self.with_features()? } else { self };
        let has_lights = layers.contains(&Layer::Lights);
        let film = if has_lights { film.with_light_groups(names.lights.clone())? } else { film };
        film.with_first_hits(FirstHitLayers::of(layers, names))
    }

    /// The names of what its layers show.
    pub fn layer_names(&self) -> LayerNames {
        let masks = self.first_hits().layers();
        LayerNames {
            lights: self.light_groups().cloned().unwrap_or_default(),
            objects: masks.objects.clone().unwrap_or_default(),
            materials: masks.materials.clone().unwrap_or_default(),
        }
    }

    /// A layer of the pixel of row-major index `i`; black without such a layer, and 0 behind the last
    /// number.
    pub(super) fn layer_at(&self, layer: &FileLayer, i: usize) -> [f32; 3] {
        let pixel = &self.pixels[i];
        let samples = pixel.samples;
        let surfaces = |mean: fn(&Features, u32) -> [f32; 3]| {
            self.features.get(i).map_or([0.0; 3], |features| mean(features, samples))
        };
        let hits = self.first_hits();
        match layer {
            FileLayer::Albedo => surfaces(Features::mean_albedo),
            FileLayer::Normal => surfaces(Features::mean_normal),
            FileLayer::Light(group) => self.light_at(group, i),
            FileLayer::Depth => [hits.depth(i), 0.0, 0.0],
            FileLayer::Position => hits.position(i),
            FileLayer::Uv => hits.uv(i, samples),
            FileLayer::MotionBefore => {
                let [x, y, ..] = hits.motion(i);
                [x, y, 0.0]
            }
            FileLayer::MotionAfter => {
                let [.., z, w] = hits.motion(i);
                [z, w, 0.0]
            }
            FileLayer::Rank(mask, rank) => {
                let [id, share] = hits.rank(mask.kind, *rank, i, samples);
                [id, share, 0.0]
            }
            FileLayer::Samples => [samples as f32, 0.0, 0.0],
            FileLayer::Error => pixel.error().unwrap_or([UNKNOWN_ERROR; 3]),
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
            let names = LayerNames { lights: groups.clone(), ..LayerNames::default() };
            FileLayer::all(layers, &names).iter().map(FileLayer::name).collect::<Vec<_>>()
        };
        let expected = ["albedo", "normal", "lights.fill", "lights.key", "lights.rest"];
        assert_eq!(names(&Layer::ALL[..3], &groups), expected);
        assert_eq!(names(&[Layer::Lights], &LightGroups::default()), ["lights.rest"]);
        assert_eq!(names(&[], &groups), Vec::<String>::new());
    }

    #[test]
    fn channels_are_called_as_other_programs_expect() {
        let layers = FileLayer::all(&Layer::ALL[3..], &LayerNames::default());
        let mut channels: Vec<String> = layers
            .iter()
            .flat_map(|layer| {
                let name = layer.name();
                layer.components().iter().map(move |component| format!("{name}.{component}"))
            })
            .collect();
        assert_eq!(
            channels[..6],
            ["depth.Z", "position.X", "position.Y", "position.Z", "uv.U", "uv.V"]
        );
        assert_eq!(channels[7..11], ["motion.X", "motion.Y", "motion.Z", "motion.W"]);
        assert_eq!(
            channels[11..16],
            [
                "crypto_object00.R",
                "crypto_object00.G",
                "crypto_object00.B",
                "crypto_object00.A",
                "crypto_object01.R"
            ]
        );
        assert_eq!(channels[22], "crypto_object02.A");
        assert_eq!(
            channels[34..],
            ["crypto_material02.A", "samples.X", "error.R", "error.G", "error.B"]
        );
        let count = channels.len();
        channels.sort();
        channels.dedup();
        assert_eq!(channels.len(), count, "no name twice");
    }

    #[test]
    fn the_error_is_unknown_with_one_sample() {
        let mut film = Film::new(Area::whole(2, 1), false).unwrap();
        let gray = |value: f32| [Fixed::new(value).unwrap(); 3];
        film.at_mut(0).0.add(gray(1.0), 1);
        film.at_mut(1).0.add(gray(1.0), 1);
        film.at_mut(1).0.add(gray(2.0), 1);
        let error = film.layer_of(film.area(), &FileLayer::Error);
        assert_eq!(error.rgb, [[1e10; 3], [0.5; 3]]);
        let samples = film.layer_of(film.area(), &FileLayer::Samples);
        assert_eq!(samples.rgb, [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
    }

    #[test]
    fn groups_and_the_rest_add_up_to_the_picture() {
        let groups = LightGroups::new(["a", "b"]);
        let film = Film::new(Area::whole(2, 1), false).unwrap();
        let names = LayerNames { lights: groups, ..LayerNames::default() };
        let mut film = film.with_layers(&[Layer::Lights], &names).unwrap();
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
