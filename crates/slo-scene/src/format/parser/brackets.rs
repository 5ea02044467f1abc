//! `(`, `[` or `<` instead of a brace.

use super::state::Parser;
use crate::diagnostics::{Diagnostic, Span};
use crate::format::lexer::{Token, TokenKind};
use crate::format::number::looks_like_number;
use crate::format::syntax::{Follows, Word};

/// Brackets that people write instead of `{` and `}`.
const PAIRS: [(char, char); 3] = [('(', ')'), ('[', ']'), ('<', '>')];

impl<'a> Parser<'a, '_> {
    /// Takes a bracket that comes next for the expected `{`. Reports it; the bracket
    /// that closes the block is the same mistake.
    pub(super) fn take_bracket(&mut self) {
        let text = &self.text[self.next.range.clone()];
        let pair = PAIRS.iter().find(|(open, _)| text.starts_with(*open) && may_open(text));
        let (TokenKind::Word, Some((open, close))) = (self.next.kind, pair) else { return };
        self.cut_next(1, TokenKind::Open);
        self.closer = Some(*close);
        self.report_bracket("{", *open, self.span(self.next.range.clone()));
    }

    /// A word in front of a bracket, as in `center(1`, if it is one that a block follows.
    pub(super) fn cut_at_bracket(&mut self, word: Word<'a>) -> Word<'a> {
        let Some(at) = bracket_behind(word.text) else { return word };
        let depth = self.stack.len();
        let takes_block = self.follows(depth, &word.text[..at]).is_some_and(Follows::is_block);
        if takes_block { self.cut_word(word, at) } else { word }
    }

    /// The name of an element, cut at a bracket if `{` is missing.
    pub(super) fn cut_name(&mut self, word: Word<'a>) -> Word<'a> {
        match bracket_behind(word.text) {
            Some(at) if self.next.kind != TokenKind::Open => self.cut_word(word, at),
            _ => word,
        }
    }

    /// Whether a word that can't be an attribute is a bracket instead of `}`; if so, closes the
    /// block.
    pub(super) fn closes_as_bracket(&mut self, word: Word<'_>) -> bool {
        let found = match word.text {
            ")" => ')',
            "]" => ']',
            _ => return false,
        };
        let depth = self.stack.len();
        if depth == 0 {
            return false;
        }
        let ahead = self.ahead(depth);
        if ahead.closes == 0 && ahead.is_early(self, depth) {
            let error = Diagnostic::error(format!("unexpected `{found}`"));
            self.diagnostics.push(error.at(word.span, "one too many"));
        } else {
            self.report_bracket("}", found, word.span);
            self.close(word.span);
        }
        true
    }

    /// Cuts a bracket off the end of a number.
    pub(super) fn cut_number(&mut self, word: Word<'a>) -> Word<'a> {
        let text = word.text.trim_end_matches([')', ']']);
        if self.stack.is_empty() || text.is_empty() || text.len() == word.text.len() {
            return word;
        }
        self.cut_word(word, text.len())
    }

    /// Cuts what closes a block that was opened with a bracket off the word that comes next.
    pub(super) fn cut_closer(&mut self) {
        let Some(closer) = self.stack.last().and_then(|frame| frame.closer) else { return };
        let text = &self.text[self.next.range.clone()];
        if text.starts_with('"') {
            return;
        }
        match text.find(closer) {
            Some(0) if self.next.kind == TokenKind::Word => self.cut_next(1, TokenKind::Close),
            Some(at) if self.next.kind == TokenKind::Word => self.cut_next(at, TokenKind::Word),
            _ => {}
        }
    }

    /// Cuts a bracket off the end of a number that comes next.
    pub(super) fn cut_next_number(&mut self) {
        let text = &self.text[self.next.range.clone()];
        let number = text.trim_end_matches([')', ']']);
        if looks_like_number(text) && !number.is_empty() && number.len() < text.len() {
            self.cut_next(number.len(), TokenKind::Word);
        }
    }

    fn report_bracket(&mut self, expected: &str, found: char, span: Span) {
        let message = format!("expected `{expected}`, found `{found}`");
        let error = Diagnostic::error(message).at(span, "");
        self.diagnostics.push(error.help("blocks and vectors are written in braces, `{ }`"));
    }

    /// Makes a token of the first bytes of what comes next.
    fn cut_next(&mut self, length: usize, kind: TokenKind) {
        let start = self.next.range.start;
        self.lexer.rewind(start + length);
        self.next = Token { kind, range: start..start + length };
    }

    /// Splits the word just read in two.
    fn cut_word(&mut self, word: Word<'a>, length: usize) -> Word<'a> {
        let end = word.span.start + length;
        self.reread(end);
        Word { text: &word.text[..length], span: Span { end, ..word.span } }
    }
}

/// Position of a bracket in a word that begins with something else.
fn bracket_behind(word: &str) -> Option<usize> {
    let is_quoted = word.starts_with('"');
    word.find(['(', '[', '<']).filter(|at| !is_quoted && *at > 0 && may_open(&word[*at..]))
}

/// Whether a bracket is no tag of HTML.
fn may_open(text: &str) -> bool {
    text.strip_prefix('<').is_none_or(|rest| rest.is_empty() || looks_like_number(rest))
}
