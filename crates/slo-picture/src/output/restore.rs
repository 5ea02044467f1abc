//! A recipe -> the scene with the settings that it names.

use std::fmt::{self, Display};

use serde_json::Value;

use super::recipe::{
    contrast_keyword, generator_keyword, layers_of, light_sampling_keyword, settings_of,
    shadow_keyword,
};
use crate::film::Fixed;
use slo_scene::{Accelerator, Contrast, Generator, LightSampling, SceneDescription, ShadowMode};

/// Pixels each way that a picture has at most.
pub(super) const LARGEST_SIDE: u32 = 65_536;
/// What a scene may ask for at most: samples of each kind, and bounces.
pub(super) const MOST_SAMPLES: u32 = 65_535;
const MOST_BOUNCES: u32 = 1000;

/// Why a recipe does not go with a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RestoreError {
    /// Its hash is that of other files.
    OtherScene,
    /// A setting is not one of this version.
    OtherVersion,
}

impl Display for RestoreError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::OtherScene => "it is of another scene, or of one that has changed since",
            Self::OtherVersion => "its recipe is not one of this version",
        })
    }
}

impl std::error::Error for RestoreError {}

/// The scene as a picture's recipe has it, and the frame.
///
/// # Errors
/// See [`RestoreError`].
pub fn restore(
    scene: &SceneDescription,
    recipe: &Value,
) -> Result<(SceneDescription, i64), RestoreError> {
    let hash: String = scene.content_hash.iter().map(|byte| format!("{byte:02x}")).collect();
    if recipe["sceneBlake3"] != *hash {
        return Err(RestoreError::OtherScene);
    }
    let mut scene = scene.clone();
    let frame = set(&mut scene, recipe).ok_or(RestoreError::OtherVersion)?;
    Ok((scene, frame))
}

/// Sets all that the recipe names; the frame.
fn set(scene: &mut SceneDescription, recipe: &Value) -> Option<i64> {
    let number = |key: &str| u32::try_from(recipe[key].as_u64()?).ok();
    let real = |key: &str| recipe[key].as_f64();
    let film = &mut scene.camera.film;
    let side = |key: &str| number(key).filter(|side| (1..=LARGEST_SIDE).contains(side));
    let samples = |key: &str| number(key).filter(|count| (1..=MOST_SAMPLES).contains(count));
    (film.width, film.height) = (side("width")?, side("height")?);
    (film.output, film.encoding) = settings_of(recipe)?;
    film.layers = layers_of(recipe)?;
    let settings = &mut scene.settings;
    settings.seed = recipe["seed"].as_u64()?;
    settings.generator = word(
        recipe,
        "generatorType",
        [Generator::Pseudo, Generator::ZeroTwo, Generator::Quasi],
        generator_keyword,
    )?;
    settings.light_sampling = word(
        recipe,
        "lightSamplingType",
        [LightSampling::One, LightSampling::All],
        light_sampling_keyword,
    )?;
    settings.contrast = word(
        recipe,
        "contrastType",
        [Contrast::Difference, Contrast::Weber, Contrast::Michelson],
        contrast_keyword,
    )?;
    settings.shadow =
        word(recipe, "shadow", [ShadowMode::Opaque, ShadowMode::Transparent], shadow_keyword)?;
    settings.image_samples = samples("imageSamples")?;
    settings.image_min_samples = samples("imageMinSamples")?;
    settings.image_contrast_limit = real("imageContrastLimit")? as f32;
    settings.dof_samples = samples("dofSamples")?;
    settings.soft_shadow_samples = samples("softShadowSamples")?;
    settings.diffuse_reflection_samples = samples("diffuseReflectionSamples")?;
    settings.diffuse_refraction_samples = samples("diffuseRefractionSamples")?;
    settings.recursion = number("recursion").filter(|bounces| *bounces <= MOST_BOUNCES)?;
    settings.noise = real("noise").map(|noise| noise as f32);
    settings.transform_samples_per_ms = real("transformSamplesPerMs")?;
    let all = u64::from(settings.image_samples) * u64::from(settings.dof_samples);
    let is_known = all <= u64::from(Fixed::MOST)
        && settings.image_min_samples <= settings.image_samples
        && settings.image_contrast_limit >= 0.0
        && settings.noise.is_none_or(|noise| noise > 0.0 && noise <= 1.0)
        && settings.transform_samples_per_ms > 0.0;
    if !is_known {
        return None;
    }
    settings.accelerator = match recipe.get("accelerator") {
        Some(name) => Accelerator::by_name(name.as_str()?).ok()?,
        None if settings.accelerator == Accelerator::Cwbvh => Accelerator::default(),
        None => settings.accelerator,
    };
    for (channel, value) in settings.background.iter_mut().zip(recipe["background"].as_array()?) {
        *channel = value.as_f64()? as f32;
    }
    recipe["frame"].as_i64()
}

/// The value whose keyword a member is.
fn word<T: Copy, const N: usize>(
    recipe: &Value,
    key: &str,
    values: [T; N],
    keyword: impl Fn(T) -> &'static str,
) -> Option<T> {
    let found = recipe[key].as_str()?;
    values.into_iter().find(|&value| keyword(value) == found)
}

#[cfg(test)]
mod tests {
    use super::super::Recipe;
    use super::*;
    use slo_scene::{Camera, Film, Settings};

    #[test]
    fn settings_that_no_scene_has_are_of_another_version() {
        let film = Film {
            width: 8,
            height: 8,
            prefix: String::new(),
            output: slo_scene::OutputFormat::Png8,
            encoding: slo_scene::Encoding::Raw,
            layers: Vec::new(),
        };
        let scene = SceneDescription {
            settings: Settings { noise: Some(0.5), ..Settings::default() },
            camera: Camera { fps: 25.0, film, segments: Vec::new() },
            lights: Vec::new(),
            materials: Vec::new(),
            textures: Vec::new(),
            objects: Vec::new(),
            content_hash: [7; 32],
        };
        let recipe: Value =
            serde_json::from_str(&Recipe { scene: &scene, frame: 3 }.to_json()).unwrap();
        assert_eq!(restore(&scene, &recipe).unwrap().1, 3);
        for (key, value) in [
            ("width", 65_537.0_f64),
            ("height", 0.0),
            ("imageSamples", 65_536.0),
            ("imageMinSamples", 1000.0),
            ("dofSamples", 65_536.0),
            ("softShadowSamples", 0.0),
            ("diffuseReflectionSamples", 1e9),
            ("diffuseRefractionSamples", 4_294_967_295.0),
            ("recursion", 1001.0),
            ("imageContrastLimit", -1.0),
            ("noise", 0.0),
            ("noise", 1.5),
            ("transformSamplesPerMs", 0.0),
        ] {
            let mut other = recipe.clone();
            other[key] = match value.fract() == 0.0 && value >= 0.0 && key != "noise" {
                true => (value as u64).into(),
                false => value.into(),
            };
            let found = restore(&scene, &other).map(|found| found.1);
            assert_eq!(found, Err(RestoreError::OtherVersion), "{key} {value}");
        }
    }
}
