//! Notations of other languages that this one does not have.

use super::state::{Head, Parser};
use crate::diagnostics::{Diagnostic, Span};
use crate::format::lexer::TokenKind;
use crate::format::number::looks_like_number;
use crate::format::syntax::{Block, Form, Word};

/// Digits of a colour as web pages write it, without the `#`.
const HEX_DIGITS: [usize; 3] = [3, 6, 8];

impl<'a> Parser<'a, '_> {
    /// Whether the first word of an entry belongs to another language; if so, reports it
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
                .help("use white space alone between words and numbers"),
            _ => return false,
        };
        if !word.text.starts_with("//") && self.repeats(&error.message) {
            return true;
        }
        let span = Span { end: word.span.start + word.text.len().min(2), ..word.span };
        self.diagnostics.push(error.at(span, ""));
        true
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

    pub(super) fn report_sign(&mut self, word: Word<'_>, follower: &str, sign: Word<'_>) {
        let (word, text) = (word.text, sign.text);
        let message = format!("`{word}` is followed by {follower}, without `{text}`");
        self.diagnostics.push(Diagnostic::error(message).at(sign.span, "one too many"));
    }

    /// Whether the token behind a byte is `{`.
    pub(super) fn is_open_behind(&self, at: usize) -> bool {
        let mut lexer = self.lexer.clone();
        lexer.rewind(at);
        lexer.next_token().kind == TokenKind::Open
    }

    /// An element without its block, if what follows does not belong in it.
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
        self.push_item(keyword, Form::Element(name, Box::new(block)));
        true
    }

    /// Passes over a colour such as `#cc1111`, which stands for a vector and is read as
    /// a comment. Returns whether there is one.
    pub(super) fn skip_hex_color(&mut self, behind: usize) -> bool {
        let is_vector = match self.next.kind {
            TokenKind::Open => true,
            TokenKind::Word => looks_like_number(&self.text[self.next.range.clone()]),
            _ => false,
        };
        let gap = self.text[behind..self.next.range.start].trim_start();
        let Some(rest) = gap.strip_prefix('#').filter(|_| !is_vector) else { return false };
        let digits = rest.find(|c: char| !c.is_ascii_alphanumeric()).unwrap_or(rest.len());
        let Some(channels) = channels(&rest[..digits]) else { return false };
        let start = self.next.range.start - gap.len();
        let end = start + 1 + digits;
        let vector = channels.map(|value| format!("{:.3}", f64::from(value) / 255.0)).join(" ");
        self.diagnostics.push(
            Diagnostic::error("`#` begins a comment, so this is no colour")
                .at(self.span(start..end), "")
                .help(format!("a colour is three numbers from 0 to 1: write `{{ {vector} }}`")),
        );
        self.reread(end);
        true
    }

    /// Continues reading at a byte behind the token just read.
    pub(super) fn reread(&mut self, at: usize) {
        self.lexer.rewind(at);
        self.next = self.lexer.next_token();
        self.cut_closer();
    }
}

pub(super) fn is_sign(word: &Word<'_>) -> bool {
    matches!(word.text, "=" | ":")
}

/// Red, green and blue of a colour in hexadecimal digits; its opacity is left out.
fn channels(digits: &str) -> Option<[u8; 3]> {
    if !HEX_DIGITS.contains(&digits.len()) {
        return None;
    }
    let width = if digits.len() == 3 { 1 } else { 2 };
    let channel = |i: usize| u8::from_str_radix(digits.get(i * width..(i + 1) * width)?, 16).ok();
    let unit = if width == 1 { 17 } else { 1 };
    Some([channel(0)? * unit, channel(1)? * unit, channel(2)? * unit])
}
