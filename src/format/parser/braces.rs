//! Braces that are missing or too many: where each should have been.

use super::{Head, Parser};
use crate::diagnostics::{Diagnostic, Span};
use crate::format::syntax::{Entry, Form, Item, Word};

/// How far back a line's indentation is looked for, in bytes.
const LONGEST_LINE: usize = 400;

/// Blocks that were closed in front of an element.
pub(super) struct Forced {
    /// The error if their `}` are missing.
    unclosed: Diagnostic,
    /// The error if their `}` follow, so that the element was meant to stand in them.
    nested: Diagnostic,
    /// How many blocks.
    count: usize,
}

impl Parser<'_, '_> {
    pub(super) fn close(&mut self, close: Span) {
        match self.stack.last() {
            Some(frame) => {
                self.note_indentation(frame.block.open, close);
                self.pop(close);
            }
            None => self.surplus_close(close),
        }
    }

    pub(super) fn close_all(&mut self) {
        while let Some(frame) = self.stack.last_mut() {
            frame.block.damaged = true;
            let open = frame.block.open;
            self.pop(open);
        }
    }

    /// Whether a vector such as `center { 1 2 3` goes on with a word that is an attribute of
    /// something: its `}` is missing.
    pub(super) fn is_attribute_after_vector(&self, word: Word<'_>) -> bool {
        let Some(frame) = self.stack.last() else { return false };
        let is_vector = frame.head.is_some_and(|head| head.name.is_none())
            && !frame.block.entries.is_empty()
            && !frame.has_items;
        is_vector && self.vocabulary.attributes.contains(&word.text)
    }

    pub(super) fn close_vector(&mut self, word: Word<'_>) {
        let Some(frame) = self.stack.last() else { return };
        let open = frame.block.open;
        let last = frame.block.entries.iter().rev().find_map(|e| match e {
            Entry::Number(number) => Some(number.word.span),
            Entry::Item(_) => None,
        });
        self.diagnostics.push(
            Diagnostic::error("this `{` is never closed")
                .at(open, "")
                .also(word.span, "expected a number or `}`, found this"),
        );
        self.pop(last.unwrap_or(open));
    }

    /// Closes all blocks in front of an element that stands in no other. Whether their `}` are
    /// missing or follow later will show.
    pub(super) fn close_before_element(&mut self, head: Head<'_>) {
        self.report_forced();
        let keyword = head.keyword;
        let outer = self.stack.first().and_then(|frame| frame.head);
        if let (Some(unclosed), Some(outer)) = (self.unclosed(), outer) {
            let message = format!("`{}` can't stand in another element", keyword.text);
            let nested = Diagnostic::error(&message).at(keyword.span, "");
            self.forced = Some(Forced {
                unclosed: unclosed.also(keyword.span, message),
                nested: nested.also(outer.keyword.span, "in this"),
                count: self.stack.len(),
            });
        }
        self.close_all();
    }

    /// Reports blocks that were closed in front of an element, and indeed had no `}`.
    fn report_forced(&mut self) {
        self.forced.take().into_iter().for_each(|forced| self.diagnostics.push(forced.unclosed));
    }

    pub(super) fn report_unclosed_at_end(&mut self) {
        self.report_forced();
        if !self.comment_unclosed
            && let Some(diagnostic) = self.unclosed()
        {
            self.diagnostics.push(diagnostic);
        }
    }

    /// The error about the blocks that are open now.
    fn unclosed(&mut self) -> Option<Diagnostic> {
        let open: Vec<Span> = self.stack.iter().map(|f| f.block.open).collect();
        let (innermost, outer) = open.split_last()?;
        let mut diagnostic = Diagnostic::error("this `{` is never closed").at(*innermost, "");
        for span in outer {
            diagnostic = diagnostic.also(*span, "nor is this one");
        }
        if let Some([opened, closed]) = self.suspect.take()
            && opened.start > innermost.start
        {
            diagnostic = diagnostic
                .also(opened, "perhaps it is this one that lacks its `}`...")
                .also(closed, "...as this `}` stands further left than its line");
        }
        Some(diagnostic)
    }

    fn note_indentation(&mut self, open: Span, close: Span) {
        let (of_open, _) = self.indentation(open.start);
        let (of_close, is_first) = self.indentation(close.start);
        if self.suspect.is_none() && is_first && of_close < of_open {
            self.suspect = Some([open, close]);
        }
    }

    /// White space at the start of the line of a byte, and whether nothing else precedes it there.
    /// A line too long to be written by hand counts as not indented.
    fn indentation(&self, at: usize) -> (usize, bool) {
        let nearby = &self.text.as_bytes()[at.saturating_sub(LONGEST_LINE)..at];
        let Some(newline) = nearby.iter().rposition(|b| *b == b'\n') else { return (0, false) };
        let before = &nearby[newline + 1..];
        let width = before.iter().take_while(|b| b.is_ascii_whitespace()).count();
        (width, width == before.len())
    }

    /// A `}` too many: what seemed to stand at the top of the scene since the last element was
    /// meant to stand in that element.
    fn surplus_close(&mut self, close: Span) {
        let last = self.top.iter().rposition(is_element);
        self.top.truncate(last.map_or(0, |i| i + 1));
        if self.is_late_close() {
            return;
        }
        let mut diagnostic = Diagnostic::error("this `}` closes nothing").at(close, "");
        if let Some(Entry::Item(Item { keyword, form: Form::Element(name, block) })) =
            self.top.last_mut()
        {
            block.damaged = true;
            let label = format!("`{} {}` ends here already", keyword.text, name.text);
            diagnostic = diagnostic.also(block.close, label);
        }
        self.diagnostics.push(diagnostic);
    }

    /// Whether a `}` belongs to a block that was closed in front of an element.
    fn is_late_close(&mut self) -> bool {
        if let Some(forced) = self.forced.take() {
            self.diagnostics.push(forced.nested);
            self.late_closes = forced.count;
        }
        let is_late = self.late_closes > 0;
        self.late_closes -= usize::from(is_late);
        is_late
    }
}

fn is_element(entry: &Entry<'_>) -> bool {
    matches!(entry, Entry::Item(Item { form: Form::Element(..), .. }))
}
