//! What other languages have, and this one has not.

use super::{Head, Parser};
use crate::diagnostics::{Diagnostic, Span};
use crate::format::lexer::TokenKind;
use crate::format::number::looks_like_number;
use crate::format::syntax::{Block, Form, Word};

/// Words that a name may wrongly consist of.
const MOST_WORDS: usize = 8;

impl<'a> Parser<'a, '_> {
    /// Whether a word that stands where something begins is of another language; if so, reports it
    /// and passes over it.
    pub(super) fn is_foreign(&mut self, word: Word<'_>) -> bool {
        let error = match word.text {
            text if text.starts_with("//") => {
                let rest = &self.text[word.span.start..];
                let line = rest.find('\n').unwrap_or(rest.len());
                self.reread(word.span.start + line);
                Diagnostic::error("a comment begins with `#`, not with `//`")
                    .help("write `# ...`, or `/* ... */` over several lines")
            }
            text @ (";" | ",") => Diagnostic::error(format!("unexpected `{text}`"))
                .help("white space alone separates what stands in a scene"),
            _ => return false,
        };
        if !word.text.starts_with("//") && self.repeats(&error.message) {
            return true;
        }
        let span = Span { end: word.span.start + word.text.len().min(2), ..word.span };
        self.diagnostics.push(error.at(span, ""));
        true
    }

    /// Passes over further words of a name, or a sign behind it: words that begin nothing in the
    /// element or at the top of a scene, in the same line in front of its `{`.
    pub(super) fn take_name(&mut self, keyword: Word<'_>, first: Word<'a>) {
        let tokens = std::iter::once(self.next.clone()).chain(self.following()).take(MOST_WORDS);
        let words: Vec<_> = tokens
            .take_while(|token| token.kind == TokenKind::Word)
            .map(|token| self.word_at(token.range))
            .collect();
        let Some(last) = words.last() else { return };
        let is_name = |word: &Word<'_>| {
            self.grammar.follows(Some(keyword.text), word.text).is_none()
                && self.grammar.follows(None, word.text).is_none()
                && !looks_like_number(word.text)
        };
        let end = last.span.end;
        let is_one_line = !self.text[first.span.end..end].contains('\n');
        if !words.iter().all(is_name) || !is_one_line || !self.is_open_behind(end) {
            return;
        }
        match words.as_slice() {
            [sign] if is_sign(sign) => self.report_sign(first, "`{`", *sign),
            _ => self.report_long_name(keyword, Span { end, ..first.span }),
        }
        self.reread(end);
    }

    fn report_long_name(&mut self, keyword: Word<'_>, span: Span) {
        let name: Vec<_> = self.text[span.start..span.end].split_whitespace().collect();
        self.diagnostics.push(Diagnostic::error("a name is one word").at(span, "").help(format!(
            "write `{} {} {{ ... }}`",
            keyword.text,
            name.join("_")
        )));
    }

    /// Passes over `=` or `:` between an attribute and its value.
    pub(super) fn skip_sign(&mut self, keyword: Word<'_>) {
        let sign = self.word_at(self.next.range.clone());
        let after = self.lexer.clone().next_token();
        let value = &self.text[after.range];
        let is_value = match after.kind {
            TokenKind::Open => true,
            TokenKind::Word => self.follows(self.stack.len(), value).is_none(),
            _ => false,
        };
        if is_sign(&sign) && is_value {
            self.report_sign(keyword, "its value", sign);
            self.advance();
        }
    }

    fn report_sign(&mut self, word: Word<'_>, follower: &str, sign: Word<'_>) {
        let (word, text) = (word.text, sign.text);
        let message = format!("`{word}` is followed by {follower}, without `{text}`");
        self.diagnostics.push(Diagnostic::error(message).at(sign.span, "one too many"));
    }

    /// Whether the token behind a byte is `{`.
    fn is_open_behind(&self, at: usize) -> bool {
        let mut lexer = self.lexer.clone();
        lexer.rewind(at);
        lexer.next_token().kind == TokenKind::Open
    }

    /// An element without its block, where what follows does not belong in it.
    pub(super) fn element_without_block(&mut self, keyword: Word<'a>, name: Word<'a>) -> bool {
        let next = &self.text[self.next.range.clone()];
        let is_inside = self.next.kind == TokenKind::Open
            || self.grammar.follows(Some(keyword.text), next).is_some()
            || (self.next.kind == TokenKind::Word && looks_like_number(next));
        let depth = self.stack.len();
        let is_outside = matches!(self.next.kind, TokenKind::End | TokenKind::Close)
            || self.follows(depth, next).is_some();
        if is_inside || !is_outside {
            return false;
        }
        let head = Head { keyword, name: Some(name) };
        let mut error = Diagnostic::error(format!("expected `{{` after `{}`", head.title()))
            .at(name.span, "expected `{` after this");
        if looks_like_number(name.text) {
            error = error.help(format!("write `{} NAME {{ {} }}`", keyword.text, name.text));
        }
        self.diagnostics.push(error);
        let end = Span { start: name.span.end, ..name.span };
        let block = Block { open: end, close: end, entries: Vec::new(), damaged: true };
        self.push_item(keyword, Form::Element(name, block));
        true
    }

    /// The rest of a value that begins with a quote, up to the word that ends with one, in its line.
    pub(super) fn take_quoted(&mut self, word: Word<'a>) -> Word<'a> {
        let rest = &self.text[word.span.start..];
        let line = &rest[..rest.find(['\n', '{', '}']).unwrap_or(rest.len())];
        let quote = line.strip_prefix('"').and_then(|line| line.find('"'));
        match quote.map(|at| at + 2) {
            Some(length) if length > word.text.len() => {
                let end = word.span.start + length;
                self.reread(end);
                Word { text: &line[..length], span: Span { end, ..word.span } }
            }
            _ => word,
        }
    }

    /// Goes on reading at a byte behind the token just read.
    pub(super) fn reread(&mut self, at: usize) {
        self.lexer.rewind(at);
        self.next = self.lexer.next_token();
        self.cut_closer();
    }
}

fn is_sign(word: &Word<'_>) -> bool {
    matches!(word.text, "=" | ":")
}
