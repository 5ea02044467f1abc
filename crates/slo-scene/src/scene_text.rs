//! The bytes of a scene text -> a text that can be read, as a source of diagnostics.

use std::borrow::Cow;

use crate::diagnostics::{Diagnostic, Diagnostics, Source, SourceId, Span};
use crate::file_kinds::{self, Kind};
use crate::mesh::{self, BYTE_ORDER_MARK};

/// The text in the bytes of a file, which becomes a source of `diagnostics`; `None` if it is no scene
/// text, which is reported. `included_at`: where another text includes it.
pub(crate) fn scene_text<'b>(
    name: String,
    bytes: &'b [u8],
    included_at: Option<Span>,
    diagnostics: &mut Diagnostics,
) -> Option<(SourceId, Cow<'b, str>)> {
    let text = decode(bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes));
    let is_text = !text.contains('\0') && file_kinds::kind_of_text(bytes).is_none();
    let shown = if is_text { text.replace("\r\n", " \n") } else { String::new() };
    let source = diagnostics.add_source(Source { name, text: shown, first_line: 1, included_at });
    if !is_text {
        let error = not_a_text(bytes);
        diagnostics.push(match included_at {
            Some(_) => error.at(Span { source, start: 0, end: 0 }, ""),
            None => error,
        });
        return None;
    }
    if let Cow::Owned(_) = text {
        diagnostics.push(not_utf_8(bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes), source));
    }
    if let Some(kind) = mesh::kind(text.as_bytes()) {
        diagnostics.push(not_a_scene(kind, source));
        return None;
    }
    Some((source, text))
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
