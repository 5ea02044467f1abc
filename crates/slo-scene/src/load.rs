//! From the bytes of a scene text to a scene with its errors and warnings.

use std::borrow::Cow;

use crate::description::SceneDescription;
use crate::diagnostics::{Diagnostic, Diagnostics, Source, SourceId, Span};
use crate::file_kinds::{self, Kind};
use crate::files::{ContentHash, Files};
use crate::mesh::{self, BYTE_ORDER_MARK};
use crate::resolve::resolve;

/// The result of loading a scene text.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// `None` if there are errors.
    pub scene: Option<SceneDescription>,
    /// Errors and warnings, with the texts that they point into.
    pub diagnostics: Diagnostics,
}

/// The scene that a text describes, with its meshes and textures loaded.
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
    let text = decode(bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes));
    let is_text = !text.contains('\0') && file_kinds::kind_of_text(bytes).is_none();
    let shown = if is_text { text.replace("\r\n", " \n") } else { String::new() };
    let source =
        diagnostics.add_source(Source { name: text_name.to_owned(), text: shown, first_line: 1 });
    if !is_text {
        diagnostics.push(not_a_text(bytes));
        return Loaded { scene: None, diagnostics };
    }
    if let Cow::Owned(_) = text {
        diagnostics.push(not_utf_8(bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes), source));
    }
    if let Some(kind) = mesh::kind(text.as_bytes()) {
        diagnostics.push(not_a_scene(kind, source));
        return Loaded { scene: None, diagnostics };
    }
    let hash = ContentHash::new(bytes);
    let scene = resolve(&text, source, files, hash, adapt, &mut diagnostics);
    Loaded { scene: scene.filter(|_| !diagnostics.has_errors()), diagnostics }
}

fn not_a_scene(kind: &str, source: SourceId) -> Diagnostic {
    Diagnostic::error(format!("this is a .{kind} mesh, not a scene"))
        .at(Span { source, start: 0, end: 3 }, "")
        .help("a scene loads it with `mesh NAME { filename PATH material NAME }`")
}

/// The text, with U+FFFD in place of bytes that are not UTF-8.
fn decode(bytes: &[u8]) -> Cow<'_, str> {
    String::from_utf8_lossy(bytes)
}

fn not_a_text(bytes: &[u8]) -> Diagnostic {
    match file_kinds::kind_of_text(bytes) {
        Some(Kind { name, help }) => Diagnostic::error(format!("the scene is {name}")).help(help),
        None => Diagnostic::error("the scene is not a text, but a binary file"),
    }
}

/// The error about the first byte that is not UTF-8.
fn not_utf_8(bytes: &[u8], source: SourceId) -> Diagnostic {
    let start = bytes.utf8_chunks().next().map_or(0, |chunk| chunk.valid().len());
    let places = bytes.utf8_chunks().filter(|chunk| !chunk.invalid().is_empty()).count();
    let byte = bytes.get(start).copied().unwrap_or(0);
    let span = Span { source, start, end: start + '\u{fffd}'.len_utf8() };
    let label = match places {
        1 => format!("the byte 0x{byte:02x}"),
        n => format!("the byte 0x{byte:02x}, and {} more places", n - 1),
    };
    Diagnostic::error("the scene is not UTF-8 text").at(span, label).help(
        "save it as UTF-8; texts of older Windows programs are often Windows-1250 or Windows-1252",
    )
}
