//! How a picture was made, inside the picture.
//!
//! The recipe holds what can change the picture, so that two files with the same recipe have the
//! same bytes; it holds nothing else: no threads, no sections, no host, no time; and of structures none
//! but the one that is not ours, which may miss hits.

use std::fmt::{self, Display, Write};
use std::fs::File;
use std::io::{self, BufReader, Read, Seek};
use std::path::Path;

use exr::meta::MetaData;
use exr::meta::attribute::AttributeValue;

use super::chunks;
use super::file::open_regular;
use super::seal::{self, Seal};
use crate::film::{Area, Layer, Steps};
use slo_scene::{
    Accelerator, Contrast, Encoding, Film, Generator, LightSampling, OutputFormat,
    SceneDescription, Settings, ShadowMode,
};

/// Keyword of the PNG text chunk and name of the EXR attribute that hold the recipe.
pub const KEYWORD: &str = "slo-rt recipe";

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
    /// spelling of the scene language.
    pub fn to_json(&self) -> String {
        let mut json = Members::default();
        json.text("program", "slo-rt");
        json.text("version", env!("CARGO_PKG_VERSION"));
        json.text("sceneBlake3", hex(&self.scene.content_hash));
        json.number("frame", self.frame);
        add_film(&mut json, &self.scene.camera.film);
        add_settings(&mut json, &self.scene.settings);
        json.finish()
    }
}

/// A recipe of a picture, for a region of it.
pub fn with_region(recipe: String, region: Area) -> String {
    let Area { x0, y0, .. } = region;
    let (width, height) = (region.width(), region.height());
    let whole = recipe.strip_suffix("\n}").unwrap_or(&recipe);
    format!("{whole},\n  \"region\": [{x0}, {y0}, {width}, {height}]\n}}")
}

/// A recipe of a picture that was taken so far, step by step, whatever the scene's rule is.
pub fn with_steps(recipe: String, steps: Steps) -> String {
    let Steps { done, tiles } = steps;
    let whole = recipe.strip_suffix("\n}").unwrap_or(&recipe);
    format!("{whole},\n  \"steps\": [{done}, {tiles}]\n}}")
}

/// The steps of a recipe; `None` where it has none.
pub fn steps_of(recipe: &serde_json::Value) -> Option<Steps> {
    let number = |i: usize| u32::try_from(recipe.get("steps")?.get(i)?.as_u64()?).ok();
    Some(Steps { done: number(0)?, tiles: number(1)? })
}

/// File format and encoding that a recipe asks for; `None` where it names none.
pub fn settings_of(recipe: &serde_json::Value) -> Option<(OutputFormat, Encoding)> {
    let (output, encoding) = (recipe["output"].as_str()?, recipe["encoding"].as_str()?);
    let formats = [OutputFormat::Png8, OutputFormat::Png16, OutputFormat::Exr];
    let format = formats.into_iter().find(|&format| output_keyword(format) == output)?;
    let encodings = [Encoding::Raw, Encoding::Srgb];
    Some((format, encodings.into_iter().find(|&e| encoding_keyword(e) == encoding)?))
}

/// The layers that a recipe asks for, in its order; `None` where it names one that there is not.
pub fn layers_of(recipe: &serde_json::Value) -> Option<Vec<Layer>> {
    let layer = |name: &serde_json::Value| {
        let name = name.as_str()?;
        Layer::ALL.into_iter().find(|layer| layer.name() == name)
    };
    match recipe.get("layers") {
        None => Some(Vec::new()),
        Some(names) => names.as_array()?.iter().map(layer).collect(),
    }
}

fn add_film(json: &mut Members, film: &Film) {
    json.number("width", film.width);
    json.number("height", film.height);
    json.text("output", output_keyword(film.output));
    json.text("encoding", encoding_keyword(film.encoding));
    if !film.layers.is_empty() {
        let names: Vec<_> = film.layers.iter().map(|layer| layer.name()).collect();
        json.number("layers", format_args!("{names:?}"));
    }
}

/// Every setting that can change a picture. The pattern names all of them, so that a new one has
/// to be put on one side or the other.
fn add_settings(json: &mut Members, settings: &Settings) {
    let Settings {
        generator,
        light_sampling,
        contrast,
        image_samples,
        image_min_samples,
        image_contrast_limit,
        dof_samples,
        soft_shadow_samples,
        diffuse_reflection_samples,
        diffuse_refraction_samples,
        recursion,
        sections_horizontal: _,
        sections_vertical: _,
        parallel_threads: _,
        sections_per_thread: _,
        background,
        seed,
        accelerator,
        spatial_splits: _,
        shadow,
        noise,
        transform_samples_per_ms,
    } = settings;
    json.number("seed", seed);
    json.text("generatorType", generator_keyword(*generator));
    json.text("lightSamplingType", light_sampling_keyword(*light_sampling));
    json.text("contrastType", contrast_keyword(*contrast));
    json.number("imageSamples", image_samples);
    json.number("imageMinSamples", image_min_samples);
    json.number("imageContrastLimit", format_args!("{image_contrast_limit:?}"));
    json.number("dofSamples", dof_samples);
    json.number("softShadowSamples", soft_shadow_samples);
    json.number("diffuseReflectionSamples", diffuse_reflection_samples);
    json.number("diffuseRefractionSamples", diffuse_refraction_samples);
    json.number("recursion", recursion);
    json.number("background", format_args!("{background:?}"));
    json.text("shadow", shadow_keyword(*shadow));
    if let Some(noise) = noise {
        json.number("noise", format_args!("{noise:?}"));
    }
    json.number("transformSamplesPerMs", format_args!("{transform_samples_per_ms:?}"));
    if *accelerator == Accelerator::Cwbvh {
        json.text("accelerator", accelerator);
    }
}

/// The members of a JSON object in the order of their adding.
///
/// By hand, since a JSON library turns an `f32` into an `f64` of 17 digits, and 0.03 is what the
/// scene says.
#[derive(Default)]
struct Members(String);

impl Members {
    fn number(&mut self, key: &str, value: impl Display) {
        let separator = if self.0.is_empty() { "{\n" } else { ",\n" };
        let _ = write!(self.0, "{separator}  \"{key}\": {value}");
    }

    /// `value` must need no escape: keywords, versions, digits.
    fn text(&mut self, key: &str, value: impl Display) {
        self.number(key, format_args!("\"{value}\""));
    }

    fn finish(self) -> String {
        self.0 + "\n}"
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |text, byte| text + &format!("{byte:02x}"))
}

/// The word of the scene language for it.
pub fn output_keyword(format: OutputFormat) -> &'static str {
    match format {
        OutputFormat::Png8 => "PNG_IMAGE",
        OutputFormat::Png16 => "PNG16_IMAGE",
        OutputFormat::Exr => "EXR_IMAGE",
    }
}

/// The word of the scene language for it.
pub fn encoding_keyword(encoding: Encoding) -> &'static str {
    match encoding {
        Encoding::Raw => "RAW",
        Encoding::Srgb => "SRGB",
    }
}

pub(super) fn generator_keyword(generator: Generator) -> &'static str {
    match generator {
        Generator::Pseudo => "PSEUDO",
        Generator::ZeroTwo => "ZERO_TWO",
        Generator::Quasi => "QUASI",
    }
}

pub(super) fn light_sampling_keyword(sampling: LightSampling) -> &'static str {
    match sampling {
        LightSampling::One => "SAMPLE_ONE_AT_TIME",
        LightSampling::All => "SAMPLE_ALL_AT_TIME",
    }
}

pub(super) fn contrast_keyword(contrast: Contrast) -> &'static str {
    match contrast {
        Contrast::Difference => "DIFFERENCE",
        Contrast::Weber => "WEBER",
        Contrast::Michelson => "MICHELSON",
    }
}

pub(super) fn shadow_keyword(shadow: ShadowMode) -> &'static str {
    match shadow {
        ShadowMode::Opaque => "OPAQUE",
        ShadowMode::Transparent => "TRANSPARENT",
    }
}

/// Why a file's recipe can't be read.
#[derive(Debug)]
pub enum RecipeError {
    /// The file can't be read.
    Io(io::Error),
    /// It is no PNG or EXR file: what its reader says.
    NotAPicture(String),
    /// It is not the file that was written: what is damaged.
    Damaged(String),
    /// A sound file that holds no recipe.
    NoRecipe,
}

impl Display for RecipeError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Io(error) => write!(f, "{error}"),
            Self::NotAPicture(why) => write!(f, "not a PNG or EXR picture: {why}"),
            Self::Damaged(why) => f.write_str(why),
            Self::NoRecipe => write!(f, "the picture holds no recipe of slo-rt"),
        }
    }
}

impl std::error::Error for RecipeError {}

/// The recipe inside the PNG or EXR file at `path`, as it was written. Reads all of the file, and checks
/// its checksums.
///
/// # Errors
/// See [`RecipeError`].
pub fn read_recipe(path: &Path) -> Result<String, RecipeError> {
    read_checked(path).map(|(recipe, _)| recipe)
}

/// Whether a file with a recipe is the one that was written with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wholeness {
    /// It is.
    Whole,
    /// Another program has read it, kept the recipe and written a file of its own.
    Resaved,
}

/// The recipe, and what became of its file.
pub(super) fn read_checked(path: &Path) -> Result<(String, Wholeness), RecipeError> {
    let mut file = open_regular(path).map_err(RecipeError::Io)?;
    let mut magic = Vec::new();
    Read::take(&mut file, 4).read_to_end(&mut magic).map_err(RecipeError::Io)?;
    file.rewind().map_err(RecipeError::Io)?;
    match magic[..] {
        [0x89, b'P', b'N', b'G'] => from_png(BufReader::with_capacity(1 << 17, file)),
        [0x76, 0x2f, 0x31, 0x01] => from_exr(BufReader::new(file)),
        _ => Err(RecipeError::NotAPicture("its first bytes are of another kind of file".into())),
    }
}

fn from_png(mut file: BufReader<File>) -> Result<(String, Wholeness), RecipeError> {
    let is_ours = chunks::scan(&mut file).map_err(|error| match error.kind() {
        io::ErrorKind::InvalidData => RecipeError::Damaged(error.to_string()),
        _ => RecipeError::Io(error),
    })?;
    file.rewind().map_err(RecipeError::Io)?;
    let reader = png::Decoder::new(file)
        .read_info()
        .map_err(|error| RecipeError::NotAPicture(super::png::reason(&error)))?;
    let mut texts = reader.info().uncompressed_latin1_text.iter();
    let recipe = texts.find(|chunk| chunk.keyword == KEYWORD).ok_or(RecipeError::NoRecipe)?;
    let wholeness = if is_ours { Wholeness::Whole } else { Wholeness::Resaved };
    Ok((recipe.text.clone(), wholeness))
}

fn from_exr(mut file: BufReader<File>) -> Result<(String, Wholeness), RecipeError> {
    let seal = seal::look(&mut file).map_err(RecipeError::Io)?;
    file.rewind().map_err(RecipeError::Io)?;
    let meta = MetaData::read_from_buffered(&mut file, false);
    let damaged = || RecipeError::Damaged("it is damaged: its checksum is wrong".into());
    let meta = meta.map_err(|error| match seal {
        Seal::Broken => damaged(),
        _ => RecipeError::NotAPicture(error.to_string()),
    })?;
    let attributes = meta.headers.iter().flat_map(|header| {
        header.own_attributes.other.iter().chain(&header.shared_attributes.other)
    });
    let recipe = attributes.into_iter().find_map(|(name, value)| match value {
        AttributeValue::Text(text) if name.eq(KEYWORD) => Some(text.to_string()),
        _ => None,
    });
    let is_ours = super::exr::is_our_header(&mut file, &meta).map_err(RecipeError::Io)?;
    match (seal, recipe) {
        (Seal::Whole, Some(recipe)) => Ok((recipe, Wholeness::Whole)),
        (Seal::Broken, _) | (Seal::None, Some(_)) if is_ours => Err(damaged()),
        (_, Some(recipe)) => Ok((recipe, Wholeness::Resaved)),
        (_, None) => Err(RecipeError::NoRecipe),
    }
}

#[cfg(test)]
mod tests {
    use super::super::Picture;
    use super::super::tests::{bytes, sample_image};
    use super::*;
    use slo_scene::Camera;

    fn scene() -> SceneDescription {
        let film = Film {
            width: 320,
            height: 240,
            prefix: "ignored".into(),
            output: OutputFormat::Png16,
            encoding: Encoding::Srgb,
            layers: Vec::new(),
        };
        SceneDescription {
            settings: Settings::default(),
            camera: Camera { fps: 25.0, film, segments: Vec::new() },
            lights: Vec::new(),
            materials: Vec::new(),
            textures: Vec::new(),
            objects: Vec::new(),
            content_hash: [0xab; 32],
        }
    }

    fn json(scene: &SceneDescription) -> String {
        Recipe { scene, frame: -5 }.to_json()
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
        check(|s| s.settings.recursion = 2);
        check(|s| s.settings.background[2] = 0.5);
        check(|s| s.settings.generator = Generator::ZeroTwo);
        check(|s| s.settings.light_sampling = LightSampling::One);
        check(|s| s.settings.contrast = Contrast::Weber);
        check(|s| s.settings.shadow = ShadowMode::Transparent);
        check(|s| s.settings.noise = Some(0.5));
        check(|s| s.settings.transform_samples_per_ms = 3.0);
        check(|s| s.camera.film.width = 1);
        check(|s| s.camera.film.height = 1);
        check(|s| s.camera.film.output = OutputFormat::Exr);
        check(|s| s.camera.film.encoding = Encoding::Raw);
        check(|s| s.camera.film.layers = vec![Layer::Normal]);
    }

    #[test]
    fn regions_and_settings_of_a_recipe() {
        let area = Area { x0: 3, y0: 4, x1: 13, y1: 24 };
        let region = with_region(json(&scene()), area);
        let parsed: serde_json::Value = serde_json::from_str(&region).unwrap();
        assert_eq!(parsed["region"], serde_json::json!([3, 4, 10, 20]));
        assert_eq!(settings_of(&parsed), Some((OutputFormat::Png16, Encoding::Srgb)));
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
        assert!(json(&scene).contains("\n  \"layers\": [\"albedo\", \"normal\"],\n"));
        assert_eq!(layers(&scene), Some(Layer::ALL.to_vec()));
        for bad in [serde_json::json!(["depth"]), serde_json::json!("albedo")] {
            assert_eq!(layers_of(&serde_json::json!({ "layers": bad })), None);
        }
    }

    #[test]
    fn it_comes_back_from_every_kind_of_file() {
        let folder = tempfile::tempdir().unwrap();
        let recipe = json(&scene());
        for format in [OutputFormat::Png8, OutputFormat::Png16, OutputFormat::Exr] {
            let path = folder.path().join("picture");
            let image = sample_image();
            let encoding = Encoding::Raw;
            let picture = Picture { image: &image, format, encoding, recipe: &recipe, crop: None };
            picture.save(&path).unwrap();
            assert_eq!(read_recipe(&path).unwrap(), recipe, "{format:?}");
        }
    }

    #[test]
    fn a_damaged_file_is_told_from_one_without_a_recipe() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture");
        for format in [OutputFormat::Png8, OutputFormat::Exr] {
            let whole = bytes(format, Encoding::Raw, &sample_image());
            let at = whole.windows(13).position(|found| found == b"slo-rt recipe").unwrap();
            for at in [at, at + 40, whole.len() - 20] {
                let mut damaged = whole.clone();
                damaged[at] ^= 1;
                std::fs::write(&path, &damaged).unwrap();
                let error = read_recipe(&path).unwrap_err();
                assert!(error.to_string().starts_with("it is damaged: "), "{at}: {error}");
            }
        }
    }

    #[test]
    fn other_files_are_told_apart() {
        let folder = tempfile::tempdir().unwrap();
        let check = |content: &[u8]| {
            let path = folder.path().join("file");
            std::fs::write(&path, content).unwrap();
            read_recipe(&path).unwrap_err().to_string()
        };
        insta::assert_snapshot!(check(b""), @"not a PNG or EXR picture: its first bytes are of another kind of file");
        assert_eq!(check(b"\x89PNG\r\n\x1a\n"), "it is damaged: it ends before its last chunk");
        assert!(check(b"\x76\x2f\x31\x01\x02\0\0\0").starts_with("not a PNG or EXR picture: "));
        let mut plain = Vec::new();
        let mut encoder = png::Encoder::new(&mut plain, 1, 1);
        encoder.set_color(png::ColorType::Rgb);
        encoder.write_header().unwrap().write_image_data(&[1, 2, 3]).unwrap();
        assert_eq!(check(&plain), "the picture holds no recipe of slo-rt");
        let missing = read_recipe(&folder.path().join("missing"));
        assert!(matches!(missing, Err(RecipeError::Io(_))));
    }
}
