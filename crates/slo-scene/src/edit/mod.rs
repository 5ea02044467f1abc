//! Changes of a scene text that keep everything else: its comments, its order and its layout.
//!
//! ```
//! use slo_scene::edit::{Outline, applied};
//!
//! let text = "sphere ball { radius 1 # small\n    material red }";
//! let outline = Outline::new(text);
//! let ball = outline.element("sphere", "ball").expect("it is there");
//! let edits = ball.set("radius", "2.5");
//! let changed = "sphere ball { radius 2.5 # small\n    material red }";
//! assert_eq!(applied(text, edits).as_deref(), Some(changed));
//! ```

mod layout;
mod links;
mod number;
mod outline;
mod part;
#[cfg(test)]
mod tests;

use std::ops::Range;

pub use links::{Link, Target, path_in};
pub use number::{number, numbers};
pub use outline::Outline;
pub use part::Part;

/// One change of a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Edit {
    /// Bytes of the text that are replaced.
    pub range: Range<usize>,
    /// What stands there afterwards.
    pub text: String,
}

/// Adds lines at the end of a text, with the line endings that the text has.
pub fn append(text: &str, lines: &str) -> Edit {
    let newline = layout::newline(text);
    let before = if text.is_empty() || text.ends_with('\n') { "" } else { newline };
    let lines = lines.replace("\r\n", "\n").replace('\n', newline);
    Edit { range: text.len()..text.len(), text: format!("{before}{lines}{newline}") }
}

/// Returns a text after changes of different places, in any order. `None` if two of them overlap, or one
/// does not fit the text.
pub fn applied(text: &str, mut edits: Vec<Edit>) -> Option<String> {
    edits.sort_by_key(|edit| (edit.range.start, edit.range.end));
    let mut result = String::with_capacity(text.len());
    let mut at = 0;
    for Edit { range, text: new } in &edits {
        result.push_str(text.get(at..range.start)?);
        result.push_str(new);
        at = range.end;
    }
    result.push_str(text.get(at..)?);
    Some(result)
}
