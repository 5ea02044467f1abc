//! How a picture was made, as JSON.
//!
//! A recipe holds what the picture depends on, so that two files with the same recipe have the same
//! bytes. It holds nothing else: no threads, no sections, no host, no time.

use std::fmt::{Display, Write};

use slo_scene::SceneDescription;
use slo_scene::animation::hash_of_shapes;
use slo_scene::settings::{Effect, Entries, Value, recorded};

use crate::film::{Area, Steps};

/// What a picture was made of.
#[derive(Clone, Copy, Debug)]
pub struct Recipe<'a> {
    /// The scene, with the settings and the film that it was rendered with.
    pub scene: &'a SceneDescription,
    /// Number of the frame.
    pub frame: i64,
}

impl Recipe<'_> {
    /// The recipe as a JSON object, one member a line, ASCII only. Settings have the names and the
    /// spelling of the scene language. Reads the shapes of bending meshes that the frame shows.
    pub fn to_json(&self) -> String {
        let mut json = JsonObject::default();
        json.text("program", "slo-rt");
        json.text("version", env!("CARGO_PKG_VERSION"));
        json.text("sceneBlake3", scene_hash(self.scene));
        json.number("frame", self.frame);
        if let Some(hash) = shapes_hash(self.scene, self.frame) {
            json.text("shapesBlake3", hash);
        }
        let SceneDescription { camera, settings, .. } = self.scene;
        let mut film = camera.film.clone();
        film.encoding = Some(film.look(settings).encoding);
        json.settings(&film);
        if !film.layers.is_empty() {
            let names: Vec<_> = film.layers.iter().map(|layer| layer.name()).collect();
            json.number("layers", format_args!("{names:?}"));
        }
        json.settings(settings);
        json.finish()
    }

    /// A hash of everything that a single sample depends on: unlike the recipe, it is the same for any
    /// number of samples, and for any display.
    pub fn hash_of_samples(&self) -> [u8; 32] {
        let SceneDescription { camera, settings, .. } = self.scene;
        let mut json = JsonObject::default();
        json.text("version", env!("CARGO_PKG_VERSION"));
        json.text("sceneBlake3", scene_hash(self.scene));
        json.number("frame", self.frame);
        if let Some(hash) = shapes_hash(self.scene, self.frame) {
            json.text("shapesBlake3", hash);
        }
        json.settings_if(&camera.film, |effect| effect == Effect::Samples);
        json.settings_if(settings, |effect| effect == Effect::Samples);
        *blake3::hash(json.finish().as_bytes()).as_bytes()
    }
}

/// The hash of a scene as recipes hold it.
pub(super) fn scene_hash(scene: &SceneDescription) -> String {
    blake3::Hash::from_bytes(scene.content_hash).to_hex().to_string()
}

/// The hash of the shapes that bending meshes have in a frame, as recipes hold it.
pub(super) fn shapes_hash(scene: &SceneDescription, frame: i64) -> Option<String> {
    hash_of_shapes(scene, frame).map(|hash| blake3::Hash::from_bytes(hash).to_hex().to_string())
}

/// The recipe of a picture -> the recipe of a region of it.
pub fn with_region(recipe: String, region: Area) -> String {
    let Area { x0, y0, .. } = region;
    let (width, height) = (region.width(), region.height());
    let whole = recipe.strip_suffix("\n}").unwrap_or(&recipe);
    format!("{whole},\n  \"region\": [{x0}, {y0}, {width}, {height}]\n}}")
}

/// The recipe of a picture -> the recipe of the picture after so many steps, whatever the scene's rule is.
pub fn with_steps(recipe: String, steps: Steps) -> String {
    let Steps { done, tiles } = steps;
    let whole = recipe.strip_suffix("\n}").unwrap_or(&recipe);
    format!("{whole},\n  \"steps\": [{done}, {tiles}]\n}}")
}

/// The members of a JSON object, in the order of their adding.
///
/// Written by hand because recipes keep their bytes: `serde_json` lays objects and arrays out in
/// another way, and pictures are compared by their recipes.
#[derive(Default)]
struct JsonObject(String);

impl JsonObject {
    fn number(&mut self, key: &str, value: impl Display) {
        let separator = if self.0.is_empty() { "{\n" } else { ",\n" };
        let _ = write!(self.0, "{separator}  \"{key}\": {value}");
    }

    /// `value` must need no escape: keywords, versions, digits.
    fn text(&mut self, key: &str, value: impl Display) {
        self.number(key, format_args!("\"{value}\""));
    }

    /// Every setting that the picture depends on, spelled as in scenes.
    fn settings<S: Entries>(&mut self, of: &S) {
        self.settings_if(of, |_| true);
    }

    /// Those of them that have certain effects.
    fn settings_if<S: Entries>(&mut self, of: &S, is_wanted: impl Fn(Effect) -> bool) {
        let effect = |name| S::ENTRIES.iter().find(|entry| entry.name == name).map(|e| e.effect);
        let is_wanted = |(name, _): &(&'static str, Value)| effect(*name).is_some_and(&is_wanted);
        for (name, value) in recorded(of).into_iter().filter(is_wanted) {
            match value {
                Value::Absent => {}
                Value::Flag(is_set) => self.number(name, u8::from(is_set)),
                Value::Count(count) => self.number(name, count),
                Value::Whole(number) => self.number(name, number),
                // `Debug` is as short as possible, and JSON for very large and small numbers too.
                Value::Single(number) => self.number(name, format_args!("{number:?}")),
                Value::Double(number) => self.number(name, format_args!("{number:?}")),
                Value::Color(rgb) => self.number(name, format_args!("{rgb:?}")),
                Value::Word(word) => self.text(name, word),
                Value::Text(text) => self.number(name, serde_json::Value::from(text)),
            }
        }
    }

    fn finish(self) -> String {
        self.0 + "\n}"
    }
}

#[cfg(test)]
mod tests {
    use slo_scene::{
        Accelerator, Camera, Contrast, Encoding, Film, Generator, Layer, LightSampling, Look,
        OutputFormat, Settings, ShadowMode, ToneMap,
    };

    use super::super::read::{layers_of, settings_of, steps_of};
    use super::*;

    fn scene() -> SceneDescription {
        let mut film = Film::default();
        (film.width, film.height) = (320, 240);
        (film.output, film.encoding) = (OutputFormat::Png16, Some(Encoding::Srgb));
        SceneDescription {
            settings: Settings::default(),
            camera: Camera { fps: 25.0, film, segments: Vec::new() },
            lights: Vec::new(),
            materials: Vec::new(),
            textures: Vec::new(),
            objects: Vec::new(),
            copies: Vec::new(),
            spaces: Vec::new(),
            content_hash: [0xab; 32],
        }
    }

    fn json(scene: &SceneDescription) -> String {
        Recipe { scene, frame: -5 }.to_json()
    }

    #[test]
    fn the_hash_of_samples_does_not_know_their_number() {
        let hash = |scene: &SceneDescription| Recipe { scene, frame: 1 }.hash_of_samples();
        let (one, mut other) = (scene(), scene());
        (other.settings.image_samples, other.settings.noise) = (77, Some(0.01));
        other.camera.film.output = OutputFormat::Exr;
        assert_eq!(hash(&one), hash(&other));
        let mut seed = scene();
        seed.settings.seed = 1;
        let mut size = scene();
        size.camera.film.width = 321;
        for changed in [seed, size] {
            assert_ne!(hash(&one), hash(&changed));
        }
    }

    #[test]
    fn it_is_json_that_says_what_was_rendered() {
        let parsed: serde_json::Value = serde_json::from_str(&json(&scene())).unwrap();
        assert_eq!(parsed["program"], "slo-rt");
        assert_eq!(parsed["version"], env!("CARGO_PKG_VERSION"));
        assert_eq!(parsed["sceneBlake3"], "ab".repeat(32));
        assert_eq!(parsed["frame"], -5);
        assert_eq!(parsed["width"], 320);
        assert_eq!(parsed["output"], "PNG16_IMAGE");
        assert_eq!(parsed["encoding"], "SRGB");
        assert_eq!(parsed["imageContrastLimit"], 0.03);
        assert_eq!(parsed["background"], serde_json::json!([0.0, 0.0, 0.0]));
        assert!(parsed.get("noise").is_none());
    }

    #[test]
    fn the_look_stands_in_it_where_older_pictures_had_the_encoding() {
        let mut scene = scene();
        scene.camera.film.encoding = None;
        assert!(json(&scene).contains("\n  \"encoding\": \"RAW\",\n  \"seed\""));
        (scene.camera.film.exposure, scene.camera.film.tone_map) = (1.5, ToneMap::Agx);
        let json = json(&scene);
        let members = "\"RAW\",\n  \"exposure\": 1.5,\n  \"toneMap\": \"AGX\",\n  \"seed\"";
        assert!(json.contains(members), "{json}");
        let look = scene.camera.film.look(&scene.settings);
        let parsed = serde_json::from_str(&json).unwrap();
        assert_eq!(settings_of(&parsed), Some((OutputFormat::Png16, look)));
    }

    #[test]
    fn floats_of_any_size_are_json() {
        let mut scene = scene();
        scene.settings.background = [1e-30, 3.4e38, 0.1];
        scene.settings.noise = Some(1e-12);
        scene.settings.transform_samples_per_ms = 1e300;
        let json = json(&scene);
        assert!(serde_json::from_str::<serde_json::Value>(&json).is_ok(), "{json}");
        assert!(json.contains("\"background\": [1e-30, 3.4e38, 0.1]"), "{json}");
        assert!(json.contains("\"noise\": 1e-12"), "{json}");
    }

    #[test]
    fn what_cannot_change_the_picture_is_not_in_it() {
        let mut other = scene();
        other.settings.parallel_threads = Some(3);
        other.settings.sections_horizontal = Some(7);
        other.settings.sections_vertical = Some(2);
        other.settings.sections_per_thread = 9;
        other.settings.accelerator = Accelerator::None;
        other.settings.spatial_splits = true;
        other.camera.film.prefix = "x".into();
        assert_eq!(json(&other), json(&scene()));
    }

    #[test]
    fn what_can_change_the_picture_is_in_it() {
        let check = |change: fn(&mut SceneDescription)| {
            let mut other = scene();
            change(&mut other);
            assert_ne!(json(&other), json(&scene()), "{}", json(&other));
        };
        check(|s| s.content_hash[31] = 0);
        check(|s| s.settings.seed = 1);
        check(|s| s.settings.image_samples = 17);
        check(|s| s.settings.image_min_samples = 4);
        check(|s| s.settings.image_contrast_limit = 0.1);
        check(|s| s.settings.dof_samples = 2);
        check(|s| s.settings.soft_shadow_samples = 2);
        check(|s| s.settings.diffuse_reflection_samples = 2);
        check(|s| s.settings.diffuse_refraction_samples = 2);
        check(|s| s.settings.recursion = Some(2));
        check(|s| s.settings.background[2] = 0.5);
        check(|s| s.settings.generator = Generator::ZeroTwo);
        check(|s| s.settings.light_sampling = Some(LightSampling::One));
        check(|s| s.settings.contrast = Contrast::Weber);
        check(|s| s.settings.shadow = ShadowMode::Transparent);
        check(|s| s.settings.noise = Some(0.5));
        check(|s| s.settings.transform_samples_per_ms = 3.0);
        check(|s| s.camera.film.width = 1);
        check(|s| s.camera.film.height = 1);
        check(|s| s.camera.film.output = OutputFormat::Exr);
        check(|s| s.camera.film.encoding = Some(Encoding::Raw));
        check(|s| s.camera.film.exposure = -0.5);
        check(|s| s.camera.film.tone_map = ToneMap::Agx);
        check(|s| s.camera.film.layers = vec![Layer::Normal]);
    }

    #[test]
    fn regions_and_settings_of_a_recipe() {
        let area = Area { x0: 3, y0: 4, x1: 13, y1: 24 };
        let region = with_region(json(&scene()), area);
        let parsed: serde_json::Value = serde_json::from_str(&region).unwrap();
        assert_eq!(parsed["region"], serde_json::json!([3, 4, 10, 20]));
        assert_eq!(settings_of(&parsed), Some((OutputFormat::Png16, Look::of(Encoding::Srgb))));
        assert_eq!(settings_of(&serde_json::Value::Null), None);
        let steps = Steps { done: 7, tiles: 3 };
        let parsed: serde_json::Value =
            serde_json::from_str(&with_steps(json(&scene()), steps)).unwrap();
        assert_eq!((steps_of(&parsed), steps_of(&serde_json::Value::Null)), (Some(steps), None));
    }

    #[test]
    fn layers_are_named_where_there_are_any() {
        let mut scene = scene();
        let layers =
            |scene: &SceneDescription| layers_of(&serde_json::from_str(&json(scene)).unwrap());
        assert!(!json(&scene).contains("layers"));
        assert_eq!(layers(&scene), Some(Vec::new()));
        scene.camera.film.layers = Layer::ALL.to_vec();
        let first = "\n  \"layers\": [\"albedo\", \"normal\", \"lights\", \"depth\", ";
        assert!(json(&scene).contains(first));
        assert_eq!(layers(&scene), Some(Layer::ALL.to_vec()));
        for bad in [serde_json::json!(["depths"]), serde_json::json!("albedo")] {
            assert_eq!(layers_of(&serde_json::json!({ "layers": bad })), None);
        }
    }
}
