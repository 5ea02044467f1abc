//! What is wrong with an input, with places: values that are collected, never printed in passing.

/// A text that diagnostics point into, or an excerpt of one.
#[derive(Clone, Debug)]
pub struct Source {
    /// Path as the user gave it; shown in front of line and column.
    pub name: String,
    /// The whole text, or the lines that a diagnostic shows of a large file.
    pub text: String,
    /// Line number of the first line of `text` (1 for a whole text).
    pub first_line: usize,
}

/// Which of [`Diagnostics::sources`] a span lies in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct SourceId(pub u32);

/// A range of bytes of a source text, `start..end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Span {
    /// The text.
    pub source: SourceId,
    /// First byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
}

/// Whether rendering may go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// The scene can't be rendered.
    Error,
    /// The scene can be rendered, but probably is not what was meant.
    Warning,
}

/// A place that a diagnostic shows, with what is to be seen there.
#[derive(Clone, Debug)]
pub struct Label {
    /// What is underlined.
    pub span: Span,
    /// Words beside the underline.
    pub text: String,
}

/// One error or warning.
#[derive(Clone, Debug)]
pub struct Diagnostic {
    /// Whether rendering may go on.
    pub severity: Severity,
    /// What is wrong, in one line.
    pub message: String,
    /// The place at fault.
    pub primary: Option<Label>,
    /// Other places that explain it (the first definition, the element that refers here).
    pub secondary: Vec<Label>,
    /// What to write instead.
    pub help: Option<String>,
}
