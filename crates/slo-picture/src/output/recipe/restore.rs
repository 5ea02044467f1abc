//! A recipe -> the scene with the settings that it names.

use std::fmt::{self, Display};

use serde_json::Value;
use slo_scene::SceneDescription;
use slo_scene::settings::Effect;

use super::read::{Members, layers_of, restore_settings};
use super::write::scene_hash;

/// Why a recipe does not go with a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RestoreError {
    /// Its hash is the hash of other files.
    OtherScene,
    /// A setting does not belong to this version.
    OtherVersion,
}

impl Display for RestoreError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::OtherScene => "it belongs to another scene, or the scene has changed since",
            Self::OtherVersion => "its recipe does not fit this version of slo-rt",
        })
    }
}

impl std::error::Error for RestoreError {}

/// The scene with the settings of a picture's recipe, and the frame.
///
/// # Errors
/// See [`RestoreError`].
pub fn restore(
    scene: &SceneDescription,
    recipe: &Value,
) -> Result<(SceneDescription, i64), RestoreError> {
    if recipe["sceneBlake3"] != *scene_hash(scene) {
        return Err(RestoreError::OtherScene);
    }
    let mut scene = scene.clone();
    let frame = recipe.as_object().and_then(|members| set(&mut scene, recipe, members));
    Ok((scene, frame.ok_or(RestoreError::OtherVersion)?))
}

/// Sets all that the recipe names; returns the frame.
fn set(scene: &mut SceneDescription, recipe: &Value, members: &Members) -> Option<i64> {
    const ALL: [Effect; 3] = [Effect::Samples, Effect::Count, Effect::Display];
    restore_settings(&mut scene.camera.film, &ALL, members)?;
    restore_settings(&mut scene.settings, &ALL, members)?;
    scene.camera.film.layers = layers_of(recipe)?;
    scene.settings.are_consistent().then_some(())?;
    recipe["frame"].as_i64()
}

#[cfg(test)]
mod tests {
    use slo_scene::{Camera, Film, Settings};

    use super::super::write::Recipe;
    use super::*;

    #[test]
    fn settings_that_no_scene_has_are_of_another_version() {
        let film = Film { width: 8, height: 8, ..Film::default() };
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
