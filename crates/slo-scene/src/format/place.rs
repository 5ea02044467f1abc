//! A place in a text file, cut out of whatever is at hand of its line.

use super::error::FileError;

/// Bytes of a line that are shown on either side of a fault.
pub(crate) const EXCERPT_REACH: usize = 100;

/// Where a fault is, and what its line looks like.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    /// Line from 1.
    pub(crate) line: usize,
    /// Column from 1, in characters.
    pub(crate) column: usize,
    text: String,
    span_start: usize,
    span_len: usize,
}

impl Place {
    /// The place of `len` bytes at `start` of `bytes`, a text of which `line` and `column` (both
    /// from 1) are the place of the first byte.
    pub(crate) fn within(
        bytes: &[u8],
        line: usize,
        column: usize,
        start: usize,
        len: usize,
    ) -> Self {
        let start = start.min(bytes.len());
        let (line_start, line, column) = match last_newline(&bytes[..start]) {
            Some(newline) => (newline + 1, line + count_newlines(&bytes[..start]), 1),
            None => (0, line, column),
        };
        let column_of_cut = column;
        let line_bytes = up_to_newline(&bytes[line_start..]);
        let start = start - line_start;
        let excerpt = Excerpt::cut(line_bytes, start, len, column_of_cut > 1);
        Self {
            line,
            column: column_of_cut + count_characters(&line_bytes[..start.min(line_bytes.len())]),
            text: excerpt.text,
            span_start: excerpt.span_start,
            span_len: excerpt.span_len,
        }
    }

    /// An error here.
    pub(crate) fn error(self, message: impl Into<String>, label: impl Into<String>) -> FileError {
        FileError {
            line: self.line,
            column: self.column,
            line_text: self.text,
            span_start: self.span_start,
            span_len: self.span_len,
            message: message.into(),
            label: label.into(),
            help: None,
        }
    }
}

/// The visible part of a line.
struct Excerpt {
    text: String,
    span_start: usize,
    span_len: usize,
}

impl Excerpt {
    /// What is shown of `line` for a fault of `len` bytes at `start`; an ellipsis stands for what
    /// is not. `headless`: the line has more in front of `line`.
    fn cut(line: &[u8], start: usize, len: usize, headless: bool) -> Self {
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        let start = start.min(line.len());
        let from = character_start(line, start.saturating_sub(EXCERPT_REACH));
        let to = character_start(line, (start + EXCERPT_REACH).min(line.len()));
        let head = if headless || from > 0 { "…" } else { "" };
        let tail = if to < line.len() { "…" } else { "" };
        let before = printable(&line[from..start]);
        let fault_end = character_start(line, start.saturating_add(len).min(to)).max(start);
        let fault = printable(&line[start..fault_end]);
        let after = printable(&line[fault_end..to]);
        Self {
            text: format!("{head}{before}{fault}{after}{tail}"),
            span_start: head.len() + before.len(),
            span_len: fault.len(),
        }
    }
}

/// The start of the character that the byte at `index` belongs to.
fn character_start(bytes: &[u8], index: usize) -> usize {
    let continues = |i: usize| bytes.get(i).is_some_and(|b| b & 0xC0 == 0x80);
    (index.saturating_sub(3)..=index).rev().find(|&i| !continues(i)).unwrap_or(index)
}

/// Text that a terminal shows as it is.
fn printable(bytes: &[u8]) -> String {
    let visible =
        |c: char| if c.is_control() && c != '\t' { char::REPLACEMENT_CHARACTER } else { c };
    String::from_utf8_lossy(bytes).chars().map(visible).collect()
}

/// How many lines end in `bytes`.
pub(crate) fn count_newlines(bytes: &[u8]) -> usize {
    bytes.iter().filter(|&&b| b == b'\n').count()
}

/// How many characters start in `bytes`.
pub(crate) fn count_characters(bytes: &[u8]) -> usize {
    bytes.iter().filter(|&&b| b & 0xC0 != 0x80).count()
}

/// Index of the last line feed.
pub(crate) fn last_newline(bytes: &[u8]) -> Option<usize> {
    bytes.iter().rposition(|&b| b == b'\n')
}

/// What comes before the first line feed.
fn up_to_newline(bytes: &[u8]) -> &[u8] {
    bytes.split(|&b| b == b'\n').next().unwrap_or(bytes)
}
