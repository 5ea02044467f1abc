//! Recipes: read, compared, changed and restored.

use std::sync::LazyLock;

use crate::within_limits;
use slo_picture::film::{Area, Steps};
use slo_picture::output;
use slo_scene::{Files, SceneDescription, load};

static SCENE: LazyLock<SceneDescription> = LazyLock::new(|| {
    let text = include_str!("../../seeds/splits.txt").replace("SETTINGS", "");
    load("scene.txt", &text, &Files::in_memory("", [])).scene.expect("a scene without files")
});

pub(crate) fn run(data: &[u8]) {
    within_limits(data, |data| {
        let recipe = String::from_utf8_lossy(data);
        let own = output::Recipe { scene: &SCENE, frame: 3 }.to_json();
        output::continues(&recipe, &own);
        output::continues(&own, &recipe);
        output::has_same_samples(&recipe, &own);
        output::is_companion(&recipe);
        output::without_outcome(&recipe);
        output::with_denoiser(&recipe, "oidn");
        output::with_relit(&recipe, "lamp 2");
        output::with_region(recipe.clone().into_owned(), Area::whole(3, 4));
        output::with_steps(recipe.clone().into_owned(), Steps { done: 1, tiles: 2 });
        let Ok(mut value) = serde_json::from_slice::<serde_json::Value>(data) else { return };
        output::steps_of(&value);
        output::layers_of(&value);
        output::is_relit(&value);
        output::is_denoised(&value);
        output::is_light_map(&value);
        if let Some((format, look)) = output::settings_of(&value) {
            output::with_look(&recipe, format, look);
        }
        // Whatever it says, it is about this scene.
        if let Some(members) = value.as_object_mut() {
            let known: serde_json::Value = serde_json::from_str(&own).expect("a recipe");
            members.insert("sceneBlake3".into(), known["sceneBlake3"].clone());
        }
        if let Ok((scene, frame)) = output::restore(&SCENE, &value) {
            output::Recipe { scene: &scene, frame }.to_json();
        }
    });
}
