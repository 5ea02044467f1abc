//! Names that the user chose: in quotes, or wrongly of several words.

use super::foreign::is_sign;
use super::state::Parser;
use crate::diagnostics::Diagnostic;
use crate::format::lexer::TokenKind;
use crate::format::number::looks_like_number;
use crate::format::syntax::{Follows, Word};

/// Most words that a name may wrongly consist of.
const MOST_WORDS: usize = 8;

/// Most values of several words that are looked up in the text.
const MOST_LOOKUPS: usize = 20;

/// The longest extension of a file's name, without its point.
const LONGEST_EXTENSION: usize = 5;

impl<'a> Parser<'a, '_> {
    /// A name without its quotes; `None` for one that is empty or whose quotes are never closed,
    /// which is reported.
    pub(super) fn unquoted(&mut self, word: Word<'a>) -> Option<Word<'a>> {
        let Some(rest) = word.text.strip_prefix('"') else { return Some(word) };
        let (fault, help) = match rest.strip_suffix('"') {
            Some("") => ("a name can't be empty", "write it between the quotes"),
            Some(name) => return Some(Word { text: name, ..word }),
            None => ("this `\"` is never closed", "a name in quotes ends in the line it begins in"),
        };
        self.diagnostics.push(Diagnostic::error(fault).at(word.span, "").help(help));
        if rest.is_empty() || !rest.ends_with('"') {
            self.skip_line();
        }
        None
    }

    /// Passes over the words up to the end of the line, or to a brace.
    fn skip_line(&mut self) {
        let start = self.next.range.start;
        let behind = self.text[..start].trim_end().len();
        if self.text[behind..start].contains(['\n', '\r']) {
            return;
        }
        let rest = &self.text[start..];
        self.reread(start + rest.find(['\n', '\r', '{', '}']).unwrap_or(rest.len()));
    }

    /// The whole name of an element whose first word was read. It should be one word, but takes all
    /// that begin nothing in the element or at the top of a scene, in the line and in front of `{`.
    pub(super) fn take_name(&mut self, keyword: Word<'_>, first: Word<'a>) -> Word<'a> {
        let words = self.words_ahead(first);
        let is_unclosed = first.text.starts_with('"') && !first.text[1..].ends_with('"');
        let Some(last) = words.last().filter(|_| !is_unclosed) else { return first };
        let is_name = |word: &Word<'_>| {
            self.grammar.follows(Some(keyword.text), word.text).is_none()
                && self.grammar.follows(None, word.text).is_none()
                && !looks_like_number(word.text)
        };
        let end = last.span.end;
        if !words.iter().all(is_name) || !self.is_open_behind(end) {
            return first;
        }
        let whole = self.word_at(first.span.start..end);
        let name = match words.as_slice() {
            [sign] if is_sign(sign) => {
                self.report_sign(first, "`{`", *sign);
                first
            }
            _ => {
                let name = one_line(whole.text);
                let help = format!("write `{} \"{name}\" {{ ... }}`", keyword.text);
                let error = Diagnostic::error(if name.contains(' ') {
                    "a name that holds white space stands in quotes"
                } else {
                    "a name in quotes holds no quotes"
                });
                self.diagnostics.push(error.at(whole.span, "").help(help));
                whole
            }
        };
        self.reread(end);
        name
    }

    /// The whole of a value that may be any word and of which the first word was read: of several
    /// words if they make the name of a file, or one that an element of the scene has.
    pub(super) fn take_value(&mut self, keyword: Word<'_>, first: Word<'a>) -> Word<'a> {
        if first.text.starts_with('"') || has_extension(first.text) {
            return first;
        }
        let depth = self.stack.len();
        let words = self.words_ahead(first);
        let own = |word: &&Word<'_>| {
            self.follows(depth, word.text).is_none()
                && self.follows(0, word.text) != Some(Follows::Element)
        };
        let words: Vec<_> = words.iter().take_while(own).copied().collect();
        let meant = words.into_iter().find(|last| {
            has_extension(last.text) || self.is_defined(first.span.start..last.span.end)
        });
        let Some(last) = meant else { return first };
        let whole = self.word_at(first.span.start..last.span.end);
        let help = format!("write `{} \"{}\"`", keyword.text, one_line(whole.text));
        let error = Diagnostic::error("a name or path that holds white space stands in quotes");
        self.diagnostics.push(error.at(whole.span, "").help(help));
        self.reread(last.span.end);
        whole
    }

    /// The words that follow one in its line.
    fn words_ahead(&self, first: Word<'_>) -> Vec<Word<'a>> {
        let tokens = std::iter::once(self.next.clone()).chain(self.following()).take(MOST_WORDS);
        let mut end = first.span.end;
        tokens
            .take_while(|token| {
                let gap = &self.text[end.min(token.range.start)..token.range.start];
                end = token.range.end;
                token.kind == TokenKind::Word && !gap.contains(['\n', '\r'])
            })
            .map(|token| self.word_at(token.range))
            .collect()
    }

    /// Whether words of the text are the name of a block somewhere, with quotes or without.
    fn is_defined(&mut self, words: std::ops::Range<usize>) -> bool {
        if self.lookups == MOST_LOOKUPS {
            return false;
        }
        self.lookups += 1;
        let name = &self.text[words];
        self.text.match_indices(name).any(|(at, _)| {
            let behind = &self.text[at + name.len()..];
            behind.strip_prefix('"').unwrap_or(behind).trim_start().starts_with('{')
        })
    }
}

/// Whether a word ends as names of files do.
fn has_extension(word: &str) -> bool {
    let extension = word.rsplit_once('.').map_or("", |(_, extension)| extension);
    extension.starts_with(|c: char| c.is_ascii_alphabetic())
        && extension.len() <= LONGEST_EXTENSION
        && extension.bytes().all(|b| b.is_ascii_alphanumeric())
}

/// Words with single spaces between them and without quotes.
fn one_line(words: &str) -> String {
    words.replace('"', "").split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A name as a scene writes it: in quotes if it needs them.
pub fn written(name: &str) -> std::borrow::Cow<'_, str> {
    let is_plain = !name.is_empty()
        && !name.contains(|c: char| c.is_whitespace() || matches!(c, '{' | '}'))
        && !name.starts_with(['"', '#'])
        && !name.starts_with("/*");
    if is_plain { name.into() } else { format!("\"{name}\"").into() }
}
