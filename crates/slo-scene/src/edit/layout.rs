//! Where new text goes, and what goes with removed text.

use std::ops::Range;

use super::Edit;

/// Adds something to a block, behind its last entry: on the same line if the block ends there, and otherwise
/// on a line of its own, as far from the margin as the last one. `last` is the end of the last entry.
pub(super) fn add(text: &str, open: usize, last: Option<usize>, close: usize, what: &str) -> Edit {
    let from = last.unwrap_or(open);
    if !text[from..close].contains('\n') {
        // `{}` becomes `{ what }`.
        let space = if last.is_none() && from == close { " " } else { "" };
        return Edit { range: from..from, text: format!(" {what}{space}") };
    }
    let end = line_end(text, from);
    let indent = match last {
        Some(last) => indent(text, last).to_owned(),
        None => format!("{}    ", indent(text, open)),
    };
    Edit { range: end..end, text: format!("{}{indent}{what}", newline(text)) }
}

/// Adds something on a line of its own behind what stands in a range.
pub(super) fn follow(text: &str, range: &Range<usize>, what: &str) -> Edit {
    let end = line_end(text, range.end);
    let rest = text[range.end..end].trim_start();
    // If something else follows on the line, the new text stands between the two.
    let at = if rest.is_empty() || rest.starts_with('#') { end } else { range.end };
    Edit { range: at..at, text: format!("{}{}{what}", newline(text), indent(text, range.start)) }
}

/// Takes out a range, with its lines if nothing else stands there, or else with the spaces before it.
pub(super) fn remove(text: &str, range: Range<usize>) -> Edit {
    let start = line_start(text, range.start);
    let end = line_end(text, range.end);
    let is_blank = |part: &str| part.trim().is_empty();
    let range = if is_blank(&text[start..range.start]) && is_blank(&text[range.end..end]) {
        let end = text[end..].find('\n').map_or(text.len(), |i| end + i + 1);
        start..end
    } else {
        let before = text[start..range.start].trim_end_matches([' ', '\t']).len();
        start + before..range.end
    };
    Edit { range, text: String::new() }
}

/// Where the line of a byte begins.
fn line_start(text: &str, at: usize) -> usize {
    text[..at].rfind('\n').map_or(0, |i| i + 1)
}

/// Where the line of a byte ends, before the characters that end it.
fn line_end(text: &str, at: usize) -> usize {
    let end = text[at..].find('\n').map_or(text.len(), |i| at + i);
    if text[..end].ends_with('\r') && end > at { end - 1 } else { end }
}

/// White space at the beginning of the line of a byte.
fn indent(text: &str, at: usize) -> &str {
    let line = &text[line_start(text, at)..];
    &line[..line.len() - line.trim_start_matches([' ', '\t']).len()]
}

/// What ends lines in a text.
fn newline(text: &str) -> &'static str {
    if text.contains("\r\n") { "\r\n" } else { "\n" }
}
