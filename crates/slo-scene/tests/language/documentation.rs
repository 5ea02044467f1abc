//! The scenes of the documentation are scenes.

use std::path::Path;

use slo_scene::{Files, load};

/// Files that the scenes name. What kind a file is, its first bytes say.
const FILES: &[(&str, &[u8])] = &[("sky.hdr", include_bytes!("../scenes/files/plank.png"))];

/// The indented blocks of a page that are whole scenes.
fn scenes(page: &str) -> Vec<String> {
    let mut blocks = vec![String::new()];
    for line in page.lines() {
        match (line.strip_prefix("    "), blocks.last_mut()) {
            (Some(line), Some(block)) => block.push_str(&format!("{line}\n")),
            (None, Some(block)) if line.is_empty() && !block.is_empty() => block.push('\n'),
            _ => blocks.push(String::new()),
        }
    }
    let is_scene = |block: &String| block.lines().any(|line| line.starts_with("Camera main"));
    blocks.into_iter().filter(is_scene).collect()
}

#[test]
fn nothing_is_said_about_the_scenes_of_the_documentation() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/scene-format.md");
    let page = std::fs::read_to_string(page).expect("the page exists");
    let scenes = scenes(&page);
    assert_eq!(scenes.len(), 4, "{scenes:#?}");
    for scene in scenes {
        let loaded = load("scene.txt", &scene, &Files::built_in("", FILES));
        assert_eq!(loaded.diagnostics.render(false), "", "{scene}");
    }
}
