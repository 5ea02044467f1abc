//! From the bytes of a scene text to a scene with its errors and warnings.

use crate::description::SceneDescription;
use crate::diagnostics::Diagnostics;
use crate::files::{ContentHash, Files};
use crate::resolve::resolve;
use crate::scene_text::scene_text;

/// The result of loading a scene text.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// `None` if there are errors.
    pub scene: Option<SceneDescription>,
    /// Errors and warnings, with the texts that they point into.
    pub diagnostics: Diagnostics,
}

/// The scene that a text describes, with all that it includes, and its meshes and textures loaded.
///
/// `text_name` is what messages call the text: its path as the user gave it. Everything that is
/// wrong is found in one pass; `files` says where meshes and textures are.
pub fn load(text_name: &str, text: impl AsRef<[u8]>, files: &Files) -> Loaded {
    load_adapted(text_name, text, files, &|_| {})
}

/// The same for a picture that differs from what the text says: `adapt` changes a scene without
/// errors, and warnings about settings without effect are about the changed scene.
pub fn load_adapted(
    text_name: &str,
    text: impl AsRef<[u8]>,
    files: &Files,
    adapt: &dyn Fn(&mut SceneDescription),
) -> Loaded {
    load_bytes(text_name, text.as_ref(), files, adapt)
}

fn load_bytes(
    text_name: &str,
    bytes: &[u8],
    files: &Files,
    adapt: &dyn Fn(&mut SceneDescription),
) -> Loaded {
    let mut diagnostics = Diagnostics::default();
    let text = scene_text(text_name.to_owned(), bytes, None, &mut diagnostics);
    let Some((source, text)) = text else { return Loaded { scene: None, diagnostics } };
    let hash = ContentHash::new(bytes);
    if let Some(known) = files.known() {
        known.begin();
    }
    let scene = resolve(&text, source, files, hash, adapt, &mut diagnostics);
    Loaded { scene: scene.filter(|_| !diagnostics.has_errors()), diagnostics }
}
