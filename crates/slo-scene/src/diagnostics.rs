//! Errors and warnings about an input, with their places: values that are collected, never printed
//! in passing.

use annotate_snippets::{
    Annotation, AnnotationKind, Group, Level, Origin, Renderer, Snippet, normalize_untrusted_str,
};

/// How many errors, and how many warnings, one report shows.
pub const SHOWN: usize = 20;

/// How many diagnostics are kept; the rest are only counted.
const KEPT: usize = 2000;

/// A text that diagnostics point into, or an excerpt of one.
#[derive(Clone, Debug)]
pub struct Source {
    /// Path as the user gave it; shown in front of line and column.
    pub name: String,
    /// The whole text, or the lines that a diagnostic shows of a large file.
    pub text: String,
    /// Line number of the first line of `text` (1 for a whole text).
    pub first_line: usize,
    /// Where another text includes this one.
    pub included_at: Option<Span>,
}

/// Which source of [`Diagnostics`] a span lies in.
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

impl Span {
    /// From the start of this span to the end of `last`, which lies in the same source.
    pub fn to(self, last: Self) -> Self {
        Self { end: last.end.max(self.start), ..self }
    }
}

/// Whether the scene can be rendered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Severity {
    /// The scene can't be rendered.
    Error,
    /// The scene can be rendered, but probably is not what was meant.
    Warning,
}

/// A place that a diagnostic shows, with words about it.
#[derive(Clone, Debug)]
pub struct Label {
    /// What is underlined.
    pub span: Span,
    /// Words beside the underline; may be empty.
    pub text: String,
}

/// One error or warning.
#[derive(Clone, Debug)]
pub struct Diagnostic {
    /// Whether the scene can be rendered.
    pub severity: Severity,
    /// What is wrong, in one line.
    pub message: String,
    /// The place of the fault; `None`: the first source as a whole.
    pub primary: Option<Label>,
    /// Other places that explain it (the first definition, the element that refers here).
    pub secondary: Vec<Label>,
    /// What to write instead.
    pub help: Option<String>,
    /// Whether an input file can't be opened, as opposed to wrong content.
    pub missing_input: bool,
}

impl Diagnostic {
    /// An error without a place.
    pub fn error(message: impl Into<String>) -> Self {
        Self::new(Severity::Error, message.into())
    }

    /// A warning without a place.
    pub fn warning(message: impl Into<String>) -> Self {
        Self::new(Severity::Warning, message.into())
    }

    fn new(severity: Severity, message: String) -> Self {
        Self {
            severity,
            message,
            primary: None,
            secondary: Vec::new(),
            help: None,
            missing_input: false,
        }
    }

    /// Underlines the place of the fault.
    #[must_use]
    pub fn at(mut self, span: Span, label: impl Into<String>) -> Self {
        self.primary = Some(Label { span, text: label.into() });
        self
    }

    /// Shows another place that explains it.
    #[must_use]
    pub fn also(mut self, span: Span, label: impl Into<String>) -> Self {
        self.secondary.push(Label { span, text: label.into() });
        self
    }

    /// Says what to write instead.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Marks that an input file is missing.
    #[must_use]
    pub fn missing_input(mut self) -> Self {
        self.missing_input = true;
        self
    }
}

/// Most characters of a message.
const LONGEST: usize = 1000;

/// Leaves out the middle of a message that is too long to be read.
fn shorten(text: &mut String) {
    if text.len() > LONGEST {
        let half = LONGEST / 2;
        let begin = text.floor_char_boundary(half);
        let end = text.ceil_char_boundary(text.len() - half);
        *text = format!("{}...{}", &text[..begin], &text[end..]);
    }
}

/// The errors and warnings of one run, with the texts that they point into.
#[derive(Clone, Debug, Default)]
pub struct Diagnostics {
    sources: Vec<Source>,
    kept: Vec<Diagnostic>,
    errors: usize,
    warnings: usize,
    missing: usize,
}

impl Diagnostics {
    /// Adds a text that spans may point into.
    pub fn add_source(&mut self, source: Source) -> SourceId {
        self.sources.push(source);
        SourceId((self.sources.len() - 1) as u32)
    }

    /// The text behind a span's source.
    pub fn source(&self, id: SourceId) -> &Source {
        &self.sources[id.0 as usize]
    }

    /// Adds an error or warning.
    pub fn push(&mut self, mut diagnostic: Diagnostic) {
        // They quote the text, whose words may be of any length.
        let labels = diagnostic.primary.iter_mut().chain(&mut diagnostic.secondary);
        let texts = labels.map(|label| &mut label.text).chain(&mut diagnostic.help);
        texts.chain([&mut diagnostic.message]).for_each(shorten);
        match diagnostic.severity {
            Severity::Error => self.errors += 1,
            Severity::Warning => self.warnings += 1,
        }
        self.missing += usize::from(diagnostic.missing_input);
        if self.kept.len() < KEPT {
            self.kept.push(diagnostic);
        }
    }

    /// Whether there is an error.
    pub fn has_errors(&self) -> bool {
        self.errors > 0
    }

    /// How many errors there are, shown or not.
    pub fn error_count(&self) -> usize {
        self.errors
    }

    /// Whether every error is about a missing file, and there is one.
    pub fn missing_input(&self) -> bool {
        self.missing > 0 && self.missing == self.errors
    }

    /// Errors and warnings in the order of their places.
    pub fn sorted(&self) -> Vec<&Diagnostic> {
        let mut sorted: Vec<_> = self.kept.iter().collect();
        sorted.sort_by_cached_key(|d| self.place(d));
        sorted
    }

    /// The report for the user, in the order of the text: at most [`SHOWN`] errors and as many
    /// warnings, then a line that counts them. Empty if there is nothing to say. Colours are
    /// ANSI escape sequences.
    pub fn render(&self, color: bool) -> String {
        let renderer = if color { Renderer::styled() } else { Renderer::plain() };
        let mut report = String::new();
        let mut shown = [0; 2];
        for diagnostic in self.sorted() {
            let count = &mut shown[diagnostic.severity as usize];
            *count += 1;
            if *count <= SHOWN {
                report.push_str(&renderer.render(&[self.group(diagnostic)]));
                report.push_str("\n\n");
            }
        }
        report.push_str(&self.summary(&renderer));
        // The renderer makes control characters visible, except those past ASCII, which some
        // terminals obey.
        report.replace(|c| ('\u{80}'..='\u{9f}').contains(&c), "\u{fffd}")
    }

    /// `error: 34 errors (20 shown), 3 warnings`
    fn summary(&self, renderer: &Renderer) -> String {
        let level = match (self.errors, self.warnings) {
            (0, 0) => return String::new(),
            (0, _) => Level::WARNING,
            _ => Level::ERROR,
        };
        let counts = [(self.errors, "error"), (self.warnings, "warning")];
        let parts: Vec<_> =
            counts.iter().filter(|(n, _)| *n > 0).map(|(n, what)| counted(*n, what)).collect();
        let title = level.primary_title(parts.join(", "));
        renderer.render(&[Group::with_title(title)]) + "\n"
    }

    fn group<'a>(&'a self, diagnostic: &'a Diagnostic) -> Group<'a> {
        let level = match diagnostic.severity {
            Severity::Error => Level::ERROR,
            Severity::Warning => Level::WARNING,
        };
        let mut group = Group::with_title(level.primary_title(diagnostic.message.as_str()));
        if diagnostic.primary.is_none()
            && let Some(source) = self.sources.first()
        {
            group = group.element(Origin::path(source.name.as_str()));
        }
        group = group.elements(self.snippets(diagnostic));
        match &diagnostic.help {
            Some(help) => group.element(Level::HELP.message(normalize_untrusted_str(help))),
            None => group,
        }
    }

    /// One snippet per source, that of the primary label first.
    fn snippets<'a>(&'a self, diagnostic: &'a Diagnostic) -> Vec<Snippet<'a, Annotation<'a>>> {
        let primary = diagnostic.primary.iter().map(|l| (l.clone(), AnnotationKind::Primary));
        let secondary = diagnostic.secondary.iter().map(|l| (l.clone(), AnnotationKind::Context));
        let mut labels: Vec<_> = primary.chain(secondary).collect();
        let mut known: Vec<Span> = Vec::new();
        for span in labels.iter().flat_map(|(label, _)| self.inclusions(label.span)) {
            if !known.contains(&span) {
                known.push(span);
            }
        }
        let included = |span| Label { span, text: "included here".into() };
        labels.extend(known.into_iter().map(|span| (included(span), AnnotationKind::Context)));
        let mut sources: Vec<SourceId> = Vec::new();
        for (label, _) in &labels {
            if !sources.contains(&label.span.source) {
                sources.push(label.span.source);
            }
        }
        let of = |id| labels.iter().filter(move |(label, _)| label.span.source == id);
        sources
            .into_iter()
            .map(|id| snippet(self.source(id), &of(id).collect::<Vec<_>>()))
            .collect()
    }

    /// Where the text of a span is included, and where the text that includes it is, and so on.
    fn inclusions(&self, span: Span) -> impl Iterator<Item = Span> {
        let outer = |span: &Span| self.source(span.source).included_at;
        std::iter::successors(outer(&span), outer)
    }

    /// Where a diagnostic stands in the report: at a place of the first source, through all that it
    /// includes.
    fn place(&self, diagnostic: &Diagnostic) -> (SourceId, Vec<usize>) {
        let spans = diagnostic.primary.iter().chain(&diagnostic.secondary).map(|l| l.span);
        let places = spans.map(|span| {
            let mut way: Vec<Span> = self.inclusions(span).collect();
            let source = way.last().map_or(span.source, |outermost| outermost.source);
            way.reverse();
            way.push(span);
            (source, way.iter().map(|span| span.start).collect())
        });
        // An error inside a mesh stands where the scene names the mesh.
        let in_main = places.clone().find(|(source, _)| source.0 == 0);
        in_main.or_else(|| places.clone().next()).unwrap_or((SourceId(u32::MAX), Vec::new()))
    }
}

fn counted(n: usize, what: &str) -> String {
    let plural = if n == 1 { "" } else { "s" };
    let shown = if n > SHOWN { format!(" ({SHOWN} shown)") } else { String::new() };
    format!("{n} {what}{plural}{shown}")
}

/// The lines from the first to the last label, with the labels.
fn snippet<'a>(
    source: &'a Source,
    labels: &[&(Label, AnnotationKind)],
) -> Snippet<'a, Annotation<'a>> {
    let text = source.text.as_str();
    let spans: Vec<_> = labels.iter().map(|(label, _)| char_range(text, label.span)).collect();
    let first = spans.iter().map(|(start, _)| *start).min().unwrap_or(0);
    let last = spans.iter().map(|(_, end)| *end).max().unwrap_or(0);
    let from = text[..first].rfind('\n').map_or(0, |i| i + 1);
    let to = text[last..].find('\n').map_or(text.len(), |i| last + i);
    let skipped = text[..from].bytes().filter(|b| *b == b'\n').count();
    let annotations = labels.iter().zip(&spans).map(|(&(label, kind), (start, end))| {
        let words = (!label.text.is_empty()).then(|| normalize_untrusted_str(&label.text));
        kind.span(start - from..end - from).label(words)
    });
    Snippet::source(&text[from..to])
        .line_start(source.first_line + skipped)
        .path(source.name.as_str())
        .annotations(annotations.collect::<Vec<_>>())
}

/// The span cut to the text and to whole characters.
fn char_range(text: &str, span: Span) -> (usize, usize) {
    let start = floor_char_boundary(text, span.start.min(text.len()));
    let end = span.end.clamp(start, text.len());
    let end = (end..=text.len()).find(|i| text.is_char_boundary(*i)).unwrap_or(text.len());
    (start, end)
}

fn floor_char_boundary(text: &str, at: usize) -> usize {
    (0..=at).rev().find(|i| text.is_char_boundary(*i)).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_of_any_length_can_be_read() {
        let mut diagnostics = Diagnostics::default();
        let long = "\u{e9}".repeat(1 << 20);
        diagnostics.push(Diagnostic::error(format!("begin {long} end")).help(long));
        let kept = diagnostics.sorted()[0];
        assert!(kept.message.starts_with("begin ") && kept.message.ends_with(" end"));
        assert!(
            kept.message.len() < 1010 && kept.help.as_ref().is_some_and(|help| help.len() < 1010)
        );
    }
}
