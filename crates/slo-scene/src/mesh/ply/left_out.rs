//! Content of a `.ply` file that its mesh leaves out.

use super::header::{Element, Header};
use crate::format::QUOTED;
use crate::mesh::warnings::sentence;

/// Properties that show that vertices or faces have colours.
const COLORS: [&str; 3] = ["red", "diffuse_red", "ambient_red"];

/// Elements that say how a mesh was made; leaving them out needs no warning.
const SILENT: [&str; 3] = ["camera", "range_grid", "face_metadata"];

/// One line for the user, if anything visible was left out.
pub(super) fn warning(header: &Header) -> Option<String> {
    let colored = |element: &str, what: &str| {
        let has_color =
            |e: &Element| e.properties.iter().any(|p| COLORS.contains(&p.name.as_str()));
        let is_there = header.elements.iter().any(|e| e.name == element && has_color(e));
        is_there.then(|| format!("colours of {what}"))
    };
    let others: Vec<String> = header
        .elements
        .iter()
        .filter(|e| e.count > 0 && e.name != "vertex" && e.name != "face")
        .filter(|e| !SILENT.contains(&e.name.as_str()))
        .take(4)
        .map(|e| format!("`{}`", quoted(&e.name)))
        .collect();
    let elements = match others.len() {
        0 => None,
        1 => Some(format!("the element {}", sentence(&others))),
        _ => Some(format!("the elements {}", sentence(&others))),
    };
    let texture = header.texture.as_ref().map(|name| format!("the texture `{}`", quoted(name)));
    let parts = [colored("vertex", "vertices"), colored("face", "faces"), texture, elements];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    (!parts.is_empty()).then(|| format!("left out: {}", sentence(&parts)))
}

/// A name for a message, cut if it is long.
fn quoted(name: &str) -> String {
    name.chars().take(QUOTED).map(|c| if c.is_control() { ' ' } else { c }).collect()
}
