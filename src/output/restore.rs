//! A recipe -> the scene with the settings that it names.

use std::fmt::{self, Display};

use serde_json::Value;

use super::recipe::{
    contrast_keyword, generator_keyword, layers_of, light_sampling_keyword, settings_of,
    shadow_keyword,
};
use crate::sampling::Generator;
use crate::scene::{Accelerator, Contrast, LightSampling, SceneDescription, ShadowMode};

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
    let side = |key: &str| number(key).filter(|side| (1..=65_536).contains(side));
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
    settings.image_samples = number("imageSamples")?;
    settings.image_min_samples = number("imageMinSamples")?;
    settings.image_contrast_limit = real("imageContrastLimit")? as f32;
    settings.dof_samples = number("dofSamples")?;
    settings.soft_shadow_samples = number("softShadowSamples")?;
    settings.diffuse_reflection_samples = number("diffuseReflectionSamples")?;
    settings.diffuse_refraction_samples = number("diffuseRefractionSamples")?;
    settings.recursion = number("recursion")?;
    settings.noise = real("noise").map(|noise| noise as f32);
    settings.transform_samples_per_ms = real("transformSamplesPerMs")?;
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
