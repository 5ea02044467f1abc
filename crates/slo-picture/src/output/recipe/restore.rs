//! A recipe -> the scene with the settings that it names.

use std::fmt::{self, Display};

use serde_json::Value;
use slo_scene::SceneDescription;
use slo_scene::settings::Effect;

use super::read::{Members, layers_of, restore_settings};
use super::write::{scene_hash, shapes_hash};

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
    let frame = frame.ok_or(RestoreError::OtherVersion)?;
    if recipe["shapesBlake3"].as_str() != shapes_hash(&scene, frame).as_deref() {
        return Err(RestoreError::OtherScene);
    }
    Ok((scene, frame))
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
    use slo_scene::settings::{Entries, Form, Value as Setting};
    use slo_scene::{Camera, Encoding, Film, Settings};

    use super::super::write::Recipe;
    use super::*;

    fn scene() -> SceneDescription {
        let mut film = Film::default();
        (film.width, film.height) = (8, 8);
        // Recipes name the encoding.
        film.encoding = Some(Encoding::Raw);
        SceneDescription {
            settings: Settings::default(),
            camera: Camera { fps: 25.0, film, segments: Vec::new() },
            lights: Vec::new(),
            materials: Vec::new(),
            textures: Vec::new(),
            objects: Vec::new(),
            copies: Vec::new(),
            spaces: Vec::new(),
            content_hash: [7; 32],
        }
    }

    fn recipe_of(scene: &SceneDescription) -> Value {
        serde_json::from_str(&Recipe { scene, frame: 3 }.to_json()).unwrap()
    }

    /// Values that differ from the defaults.
    fn others(form: Form) -> Vec<Setting> {
        match form {
            Form::Flag => vec![Setting::Flag(true), Setting::Flag(false)],
            Form::Count(..) => vec![Setting::Count(5)],
            Form::Whole => vec![Setting::Whole(u64::MAX)],
            Form::Single(_) => vec![Setting::Single(0.1)],
            Form::Double(_) => vec![Setting::Double(0.1)],
            Form::Color => vec![Setting::Color([0.1, 1e-30, 3e38])],
            Form::Word(words) => words.iter().map(|word| Setting::Word(word)).collect(),
            Form::Text(_) => vec![Setting::Text("\"x\"".into())],
        }
    }

    /// Whether a setting is in recipes exactly if the picture depends on it, and comes back from them.
    fn check_entries<S: Entries + PartialEq + std::fmt::Debug>(
        of: impl Fn(&mut SceneDescription) -> &mut S,
    ) {
        let mut plain = scene();
        plain.settings.image_min_samples = 3;
        for entry in S::ENTRIES {
            let mut is_recorded = false;
            for value in others(entry.form) {
                let mut changed = plain.clone();
                assert!(entry.set(of(&mut changed), value), "{}", entry.name);
                let recipe = recipe_of(&changed);
                let (mut restored, _) = restore(&plain, &recipe).unwrap();
                if recipe != recipe_of(&plain) {
                    is_recorded = true;
                    assert_eq!(of(&mut restored), of(&mut changed), "{}", entry.name);
                }
                let (mut back, _) = restore(&changed, &recipe_of(&plain)).unwrap();
                assert_eq!(recipe_of(&back), recipe_of(&plain), "{}", entry.name);
                assert!(is_recorded || of(&mut back) == of(&mut changed), "{}", entry.name);
            }
            assert_eq!(is_recorded, entry.effect != Effect::Nothing, "{}", entry.name);
        }
    }

    #[test]
    fn what_the_picture_depends_on_comes_back() {
        check_entries(|scene| &mut scene.settings);
        check_entries(|scene| &mut scene.camera.film);
    }

    #[test]
    fn settings_that_no_scene_has_are_of_another_version() {
        let mut scene = scene();
        scene.settings.noise = Some(0.5);
        let recipe = recipe_of(&scene);
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
