//! The scene language: fixtures of `tests/scenes`, their scenes and their messages.

use std::path::{Path, PathBuf};

use slo_rt::scene::{Files, Loaded, load};

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes")
}

/// Loads a file of `tests/scenes`, from where no path may lead out.
fn load_fixture(name: &str) -> Loaded {
    let path = fixtures().join(name);
    let text = std::fs::read(&path).expect("the fixture exists");
    let folder = path.parent().expect("it lies in a folder");
    load(name, text, &Files::on_disk(folder, &fixtures(), false))
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

#[test]
fn everything() {
    let loaded = load_fixture("everything.txt");
    assert_eq!(loaded.diagnostics.render(false), "");
    let mut scene = loaded.scene.expect("there are no errors");
    scene.content_hash = [0; 32];
    insta::assert_snapshot!("everything", format!("{}\n{scene:#?}", scene.summary()));
}

#[test]
fn byte_order_mark_and_carriage_returns() {
    let loaded = load_fixture("bom_and_crlf.txt");
    assert_eq!(loaded.diagnostics.render(false), "");
    assert!(loaded.scene.is_some());
}

/// Every file of `tests/scenes/errors`: what `--check` says about it.
#[test]
fn messages() {
    let folder = fixtures().join("errors");
    let entries = std::fs::read_dir(folder).expect("the folder exists");
    let mut names: Vec<String> = entries
        .map(|e| e.expect("it can be listed").file_name().into_string().expect("UTF-8"))
        .collect();
    names.sort();
    for name in names {
        let loaded = load_fixture(&format!("errors/{name}"));
        assert_eq!(loaded.scene.is_none(), loaded.diagnostics.has_errors(), "{name}");
        let stem = name.trim_end_matches(".txt");
        insta::assert_snapshot!(stem, loaded.diagnostics.render(false));
    }
}
