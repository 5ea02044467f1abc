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

/// Takes out a range as [`remove`] does; if it begins a line on which something else follows, that takes its
/// place.
pub(super) fn remove_word(text: &str, range: Range<usize>) -> Edit {
    let before = &text[line_start(text, range.start)..range.start];
    let rest = &text[range.end..line_end(text, range.end)];
    let follows = rest.trim_start();
    if before.trim().is_empty() && !follows.is_empty() {
        let end = range.end + rest.len() - follows.len();
        return Edit { range: range.start..end, text: String::new() };
    }
    remove(text, range)
}

/// A range with the comments that belong to it: those that fill the lines right above it, and one that
/// fills the rest of its last line.
pub(super) fn with_comments(text: &str, range: Range<usize>) -> Range<usize> {
    let mut start = line_start(text, range.start);
    if !text[start..range.start].trim().is_empty() {
        start = range.start;
    } else {
        while start > 0 {
            let above = line_start(text, start - 1);
            if !is_comment(text[above..start].trim()) {
                break;
            }
            start = above;
        }
    }
    let end = line_end(text, range.end);
    let end = if is_comment(text[range.end..end].trim()) { end } else { range.end };
    start..end
}

/// Whether a text is one comment and nothing else.
fn is_comment(text: &str) -> bool {
    let is_block = |text: &str| text.find("*/") == Some(text.len() - 2);
    text.starts_with('#')
        || text.strip_prefix("/*").is_some_and(|rest| rest.len() > 1 && is_block(rest))
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
pub(super) fn newline(text: &str) -> &'static str {
    if text.contains("\r\n") { "\r\n" } else { "\n" }
}
