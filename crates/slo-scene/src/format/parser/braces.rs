//! Missing and surplus braces: where each should have been.

use super::state::{Forced, Head, Parser};
use crate::diagnostics::{Diagnostic, Span};
use crate::format::syntax::{Entry, Form, Item, Word};

/// How far back a line's indentation is looked for, in bytes.
const LONGEST_LINE: usize = 400;

impl Parser<'_, '_> {
    pub(super) fn close(&mut self, close: Span) {
        let depth = self.stack.len();
        let Some(frame) = self.stack.last() else { return self.surplus_close(close) };
        let ahead = self.ahead(depth);
        let is_surplus = ahead.is_early(self, depth) || ahead.closes >= depth;
        if frame.unopened && is_surplus {
            self.stack[depth - 1].unopened = false;
        } else if frame.doubled > 0 && is_surplus {
            self.stack[depth - 1].doubled -= 1;
        } else if ahead.closes == 0 && ahead.is_early(self, depth) {
            self.report_early(close);
        } else {
            self.note_indentation(frame.block.open, close);
            self.pop(close);
        }
    }

    fn report_early(&mut self, close: Span) {
        if self.is_late_close() {
            return;
        }
        let next = self.span(self.next.range.clone());
        let title = self.stack.last().and_then(|frame| frame.head).map(Head::title);
        let title = title.unwrap_or_default();
        self.diagnostics.push(
            Diagnostic::error(format!("this `}}` ends `{title}` too early"))
                .at(close, "")
                .also(next, "this belongs in it"),
        );
    }

    /// Closes all blocks, which lack their `}`.
    pub(super) fn close_all(&mut self) {
        self.close_damaged(0);
    }

    fn close_damaged(&mut self, depth: usize) {
        while self.stack.len() > depth {
            let Some(frame) = self.stack.last_mut() else { return };
            frame.block.damaged = true;
            let open = frame.block.open;
            self.pop(open);
        }
    }

    /// Closes the blocks that a word can't stand in, if it can stand further out. Whether their `}`
    /// are missing or come later is decided later.
    pub(super) fn close_up_to_owner(&mut self, word: Word<'_>) {
        let depth = self.stack.len();
        let here = self.follows(depth, word.text);
        if depth == 0 || here.is_some_and(|follows| !follows.is_name()) {
            return;
        }
        let is_element = self.is_element_ahead(word.text);
        if here.is_some() && !is_element {
            return;
        }
        let mut outer = (0..depth).rev();
        let Some(owner) = outer.find(|depth| self.follows(*depth, word.text).is_some()) else {
            return;
        };
        if owner == 0 && !is_element {
            return;
        }
        if owner + 1 == depth && self.is_vector() {
            return self.close_vector(word);
        }
        if is_element && self.is_misplaced(owner) {
            return self.report_misplaced(owner, word);
        }
        self.report_forced();
        self.forced = self.force(owner, word);
        self.close_damaged(owner);
    }

    /// Reports an element in a block that it can't stand in; it will be put where it belongs.
    fn report_misplaced(&mut self, owner: usize, word: Word<'_>) {
        let Some(head) = self.stack.last().and_then(|frame| frame.head) else { return };
        self.diagnostics.push(misplaced(word, head));
        self.misplaced = Some(owner);
    }

    /// Whether the innermost block is one of numbers.
    fn is_vector(&self) -> bool {
        self.stack.last().is_some_and(|frame| {
            frame.head.is_some() && !frame.has_items && !frame.block.entries.is_empty()
        })
    }

    fn close_vector(&mut self, word: Word<'_>) {
        let Some(frame) = self.stack.last() else { return };
        let (open, last) = (frame.block.open, frame.block.entries.last());
        let close = last.map_or(open, |entry| match entry {
            Entry::Number(number) => number.word.span,
            Entry::Item(item) => item.keyword.span,
        });
        self.diagnostics.push(
            Diagnostic::error("this `{` is never closed")
                .at(open, "")
                .also(word.span, "expected a number or `}`, found this"),
        );
        self.pop(close);
    }

    fn force(&mut self, depth: usize, word: Word<'_>) -> Option<Forced> {
        let head = self.stack[depth..].iter().find_map(|frame| frame.head)?;
        let unclosed = self.unclosed(depth)?;
        let misplaced = misplaced(word, head);
        Some(Forced {
            unclosed: unclosed.also(word.span, &misplaced.message),
            misplaced,
            count: self.stack.len() - depth,
        })
    }

    /// Reports blocks that were closed before a word and indeed had no `}`.
    fn report_forced(&mut self) {
        self.forced.take().into_iter().for_each(|forced| self.diagnostics.push(forced.unclosed));
    }

    pub(super) fn report_unclosed_at_end(&mut self) {
        self.report_forced();
        if !self.comment_unclosed
            && let Some(diagnostic) = self.unclosed(0)
        {
            self.diagnostics.push(diagnostic);
        }
    }

    /// The error about the blocks that are open past a depth.
    fn unclosed(&mut self, depth: usize) -> Option<Diagnostic> {
        let open: Vec<Span> = self.stack[depth..].iter().map(|f| f.block.open).collect();
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

    /// Whether a `}` belongs to a block that was closed in front of a word.
    fn is_late_close(&mut self) -> bool {
        if let Some(forced) = self.forced.take() {
            self.diagnostics.push(forced.misplaced);
            self.late_closes = forced.count;
        }
        let is_late = self.late_closes > 0;
        self.late_closes -= usize::from(is_late);
        is_late
    }
}

fn misplaced(word: Word<'_>, head: Head<'_>) -> Diagnostic {
    Diagnostic::error(format!("`{}` can't stand in `{}`", word.text, head.keyword.text))
        .at(word.span, "")
        .also(head.keyword.span, "in this")
}

fn is_element(entry: &Entry<'_>) -> bool {
    matches!(entry, Entry::Item(Item { form: Form::Element(..), .. }))
}
