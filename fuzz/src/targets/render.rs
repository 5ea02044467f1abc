//! A scene of any text, rendered: 4 x 3 pixels with few samples, whatever the text asks for.

use crate::Worth;
use slo_accel::Isa;
use crate::{pieces, within_limits};
use slo_picture::film::{Area, Film};
use slo_render::frame::FrameScene;
use slo_render::render::{Observer, Plan, render};
use slo_scene::{Files, SceneDescription, load};

/// Larger scenes take their time rightly.
const MOST_OBJECTS: usize = 50;

struct Patient;

impl Observer for Patient {
    fn advanced(&self, _share: f64) {}

    fn should_stop(&self) -> bool {
        false
    }
}

pub(crate) fn run(data: &[u8]) -> Worth {
    let mut is_kept = false;
    within_limits(data, |data| {
        let (text, files) = pieces::files(data);
        let loaded = load("scene.txt", text, &Files::in_memory("", files));
        let Some(scene) = loaded.scene.and_then(small) else { return };
        is_kept = true;
        let Ok(frame) = FrameScene::build(&scene, 0, Isa::best()) else { return };
        let plan = Plan::new(&scene);
        let film = Film::new(Area::whole(4, 3), plan.needs_spreads()).expect("a film");
        let film = film.with_layers(&scene.camera.film.layers, &scene.layer_names());
        let film = render(&frame, &plan, film.expect("layers"), &Patient).film;
        film.image();
    });
    if is_kept { Worth::Kept } else { Worth::Nothing }
}

/// The scene with little to do.
fn small(mut scene: SceneDescription) -> Option<SceneDescription> {
    if scene.objects.len() + scene.lights.len() > MOST_OBJECTS || !scene.copies.is_empty() {
        return None;
    }
    (scene.camera.film.width, scene.camera.film.height) = (4, 3);
    let settings = &mut scene.settings;
    settings.set_camera_samples(2);
    settings.image_min_samples = settings.image_min_samples.min(2);
    settings.recursion = Some(settings.recursion().min(2));
    for count in [
        &mut settings.soft_shadow_samples,
        &mut settings.diffuse_reflection_samples,
        &mut settings.diffuse_refraction_samples,
        &mut settings.gather_rays,
        &mut settings.photon_nearest,
        &mut settings.caustic_nearest,
    ] {
        *count = (*count).min(2);
    }
    settings.photons = settings.photons.min(20.0);
    settings.photon_map_size = settings.photon_map_size.min(100);
    settings.caustic_map_size = settings.caustic_map_size.min(100);
    settings.transform_samples_per_ms = settings.transform_samples_per_ms.min(1.0);
    (!settings.guide && settings.cache_error == 0.0).then_some(scene)
}
