//! The scene language: fixtures of `tests/scenes`, their scenes and their messages.

use std::path::Path;

use slo_rt::scene::{Files, Loaded, load};

fn load_fixture(name: &str) -> Loaded {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes");
    let text = std::fs::read(folder.join(name)).expect("the fixture exists");
    load(&format!("tests/scenes/{name}"), text, &Files::on_disk(&folder, &folder, false))
}

#[test]
fn the_least_that_a_scene_needs() {
    let loaded = load_fixture("minimal.txt");
    assert_eq!(loaded.diagnostics.render(false), "");
    let scene = loaded.scene.expect("there are no errors");
    assert_eq!(scene.camera.film.prefix, "frame_");
    assert_eq!(scene.camera.segments[0].scene, [0.0, 1.0]);
    assert_eq!(scene.objects.len(), 1);
}
