//! Looking ahead: what follows shows what a brace was meant to be.

use super::state::Parser;
use crate::format::lexer::{Token, TokenKind};
use crate::format::number::looks_like_number;
use crate::format::syntax::Follows;

/// Most tokens that are read to find the end of a block. A longer block counts as one without end,
/// so that looking ahead takes no noticeable time.
const MOST_TOKENS: usize = 1000;

/// The `}` that follow at once, and what comes behind them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ahead<'a> {
    pub(super) closes: usize,
    /// Empty at the end of the text, and if something other than a word follows.
    pub(super) word: &'a str,
    /// Whether the word is followed by another one and `{`.
    pub(super) is_element: bool,
}

impl Ahead<'_> {
    /// Whether the word belongs in the block at some depth.
    pub(super) fn fits(&self, parser: &Parser<'_, '_>, depth: Option<usize>) -> bool {
        let Some(depth) = depth.filter(|depth| *depth <= parser.stack.len()) else { return false };
        match parser.follows(depth, self.word) {
            Some(follows) if follows.is_name() => !self.is_element,
            Some(Follows::Element) => self.is_element,
            Some(_) => true,
            None => depth == 0 && self.word.is_empty(),
        }
    }

    /// Whether, counting a `}` in front of all this, there is one too many for what follows to stand
    /// where it belongs.
    pub(super) fn is_early(&self, parser: &Parser<'_, '_>, depth: usize) -> bool {
        let inner = depth.checked_sub(self.closes);
        let outer = inner.and_then(|inner| inner.checked_sub(1));
        self.fits(parser, inner) && !self.fits(parser, outer)
    }
}

impl<'a> Parser<'a, '_> {
    /// What comes next; of the `}` no more than one above `most` are counted.
    pub(super) fn ahead(&self, most: usize) -> Ahead<'a> {
        self.look_ahead(&mut std::iter::once(self.next.clone()).chain(self.following()), most)
    }

    /// The tokens behind the next.
    pub(super) fn following(&self) -> impl Iterator<Item = Token> + use<'a> {
        let mut lexer = self.lexer.clone();
        std::iter::repeat_with(move || lexer.next_token())
    }

    fn look_ahead(&self, tokens: &mut dyn Iterator<Item = Token>, most: usize) -> Ahead<'a> {
        let mut next = || self.meaning(&tokens.next());
        let mut token = next();
        let mut closes = 0;
        while token.0 == TokenKind::Close && closes <= most {
            closes += 1;
            token = next();
        }
        let word = if token.0 == TokenKind::Word { token.1 } else { "" };
        let is_element = !word.is_empty() && self.is_name_and_block(word, &mut next);
        // Only a word or the end of the text fits anywhere.
        let word = if matches!(token.0, TokenKind::Word | TokenKind::End) { word } else { "{" };
        Ahead { closes, word, is_element }
    }

    /// A token as it is meant: `)` and `]` for `}`.
    fn meaning(&self, token: &Option<Token>) -> (TokenKind, &'a str) {
        let Some(token) = token else { return (TokenKind::End, "") };
        match &self.text[token.range.clone()] {
            ")" | "]" => (TokenKind::Close, ""),
            text => (token.kind, text),
        }
    }

    /// Whether a name and a block come next, behind a word just read.
    pub(super) fn is_element_ahead(&self, word: &str) -> bool {
        let mut tokens = std::iter::once(self.next.clone()).chain(self.following());
        self.is_name_and_block(word, &mut || self.meaning(&tokens.next()))
    }

    /// Whether a name and a block come next. What seems to hold an element of the scene is none:
    /// there the `{` is wrong.
    fn is_name_and_block(
        &self,
        word: &str,
        next: &mut dyn FnMut() -> (TokenKind, &'a str),
    ) -> bool {
        if next().0 != TokenKind::Word || next().0 != TokenKind::Open {
            return false;
        }
        let first = next().1;
        self.grammar.follows(None, first).is_none()
            || self.grammar.follows(Some(word), first).is_some()
    }

    /// Whether the next word is followed by its value, and not by what may stand in the innermost block.
    pub(super) fn is_value_behind(&self) -> bool {
        let Some(token) = self.following().next() else { return false };
        let text = &self.text[token.range];
        token.kind == TokenKind::Word && self.follows(self.stack.len(), text).is_none()
    }

    /// Whether an element that begins here, and belongs in the block of depth `owner`, is followed by
    /// what belongs in the innermost block: that one is not unclosed, but the element in the wrong
    /// place.
    pub(super) fn is_misplaced(&self, owner: usize) -> bool {
        let mut tokens = self.following();
        let mut depth = 0_usize;
        for token in tokens.by_ref().take(MOST_TOKENS) {
            match token.kind {
                TokenKind::Open => depth += 1,
                TokenKind::Close if depth <= 1 => break,
                TokenKind::Close => depth -= 1,
                TokenKind::End | TokenKind::UnclosedComment => return false,
                TokenKind::Word => {}
            }
        }
        let depth = self.stack.len();
        let ahead = self.look_ahead(&mut tokens, depth);
        ahead.fits(self, depth.checked_sub(ahead.closes))
            && !ahead.fits(self, owner.checked_sub(ahead.closes))
    }

    /// Whether a `{` without a name, just read, was meant to be `}`.
    pub(super) fn is_close_meant(&self) -> bool {
        self.is_close(&self.ahead(self.stack.len()))
    }

    /// Whether a `{` that comes next was meant to be `}`.
    pub(super) fn is_swapped_ahead(&self) -> bool {
        self.is_close(&self.look_ahead(&mut self.following(), self.stack.len()))
    }

    /// Whether a `}` fits in front of what follows, but neither nothing nor a `{`.
    fn is_close(&self, ahead: &Ahead<'_>) -> bool {
        let depth = self.stack.len();
        let fits = |blocks: usize| ahead.fits(self, (depth + blocks).checked_sub(1 + ahead.closes));
        depth > 0 && fits(0) && !fits(1) && !fits(2)
    }

    /// Whether a `}` that comes next, behind what should have a block, was meant to be `{`: it is
    /// followed by what belongs in that block.
    pub(super) fn is_open_meant(&self, keyword: &str, follows: Option<Follows>) -> bool {
        if self.next.kind != TokenKind::Close {
            return false;
        }
        let ahead = self.look_ahead(&mut self.following(), 0);
        let is_number = !ahead.word.is_empty() && looks_like_number(ahead.word);
        match follows {
            Some(Follows::Vector) => is_number,
            Some(Follows::Element | Follows::Block | Follows::NameOrBlock) => {
                let belongs =
                    is_number || self.grammar.follows(Some(keyword), ahead.word).is_some();
                let outside = self.follows(self.stack.len().saturating_sub(1), ahead.word);
                belongs && outside.is_none_or(|f| f == Follows::Element && !ahead.is_element)
            }
            _ => false,
        }
    }
}
