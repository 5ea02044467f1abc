//! The parser: what it has read, and what comes next.

use std::ops::Range;

use crate::diagnostics::{Diagnostic, Diagnostics, SourceId, Span};
use crate::format::lexer::{Lexer, Token, TokenKind};
use crate::format::number::{looks_like_number, parse_number};
use crate::format::syntax::{Block, Entry, Follows, Form, Grammar, Item, Number, Tree, Word};

/// Blocks deeper than this are skipped: the language needs four levels.
const MAX_DEPTH: usize = 16;

/// The syntax tree of a scene text; what is wrong with it goes to `diagnostics`, whose `source` the
/// text is.
pub fn parse<'a>(
    text: &'a str,
    source: SourceId,
    grammar: &dyn Grammar,
    diagnostics: &mut Diagnostics,
) -> Tree<'a> {
    let mut lexer = Lexer::new(text);
    let next = lexer.next_token();
    let parser = Parser {
        text,
        source,
        grammar,
        diagnostics,
        lexer,
        next,
        stack: Vec::new(),
        top: Vec::new(),
        suspect: None,
        forced: None,
        misplaced: None,
        closer: None,
        late_closes: 0,
        comment_unclosed: false,
        lookups: 0,
    };
    parser.run()
}

/// A block that is not closed yet.
pub(super) struct Frame<'a> {
    /// `None`: a block with nothing in front of it, which is dropped.
    pub(super) head: Option<Head<'a>>,
    pub(super) block: Block<'a>,
    /// Whether the block holds anything but numbers.
    pub(super) has_items: bool,
    /// How many `{` too many it began with.
    pub(super) doubled: usize,
    /// Whether it ends in a vector without its `{`.
    pub(super) unopened: bool,
    /// What closes it, if it was opened with a bracket.
    pub(super) closer: Option<char>,
    /// The depth at which it belongs, if not here.
    pub(super) home: Option<usize>,
    /// The fault of the last faulty word, without the word.
    pub(super) word_fault: Option<String>,
}

impl Frame<'_> {
    /// The keyword in front of the block.
    pub(super) fn owner(&self) -> &str {
        self.head.map_or("", |head| head.keyword.text)
    }
}

#[derive(Clone, Copy)]
pub(super) struct Head<'a> {
    pub(super) keyword: Word<'a>,
    pub(super) name: Option<Word<'a>>,
}

impl Head<'_> {
    /// As messages call it.
    pub(super) fn title(self) -> String {
        let name = self.name.map_or(String::new(), |name| format!(" {}", name.text));
        format!("{}{name}", self.keyword.text)
    }
}

/// Blocks that were closed before a word that belongs further out.
pub(super) struct Forced {
    /// The error if their `}` are missing.
    pub(super) unclosed: Diagnostic,
    /// The error if their `}` follow, so that the word was meant to be inside.
    pub(super) misplaced: Diagnostic,
    /// How many blocks.
    pub(super) count: usize,
}

pub(super) struct Parser<'a, 'v> {
    pub(super) text: &'a str,
    pub(super) source: SourceId,
    pub(super) grammar: &'v dyn Grammar,
    pub(super) diagnostics: &'v mut Diagnostics,
    pub(super) lexer: Lexer<'a>,
    pub(super) next: Token,
    pub(super) stack: Vec<Frame<'a>>,
    pub(super) top: Vec<Entry<'a>>,
    /// The first block whose `}` stands further left than the line of its `{`.
    pub(super) suspect: Option<[Span; 2]>,
    pub(super) forced: Option<Forced>,
    /// The depth at which the element whose block comes next belongs, if it stands too deep.
    pub(super) misplaced: Option<usize>,
    /// What closes the block that comes next, if it is opened with a bracket.
    pub(super) closer: Option<char>,
    /// How many `}` may still follow of blocks that were closed in front of a word.
    pub(super) late_closes: usize,
    pub(super) comment_unclosed: bool,
    /// How many names of several words were looked up in the text.
    pub(super) lookups: usize,
}

impl<'a> Parser<'a, '_> {
    pub(super) fn run(mut self) -> Tree<'a> {
        loop {
            let token = self.advance();
            match token.kind {
                TokenKind::Word => self.word(self.word_at(token.range)),
                TokenKind::Open => self.open_nameless(self.span(token.range)),
                TokenKind::Close => self.close(self.span(token.range)),
                TokenKind::UnclosedComment => self.report_comment(self.span(token.range)),
                TokenKind::End => break,
            }
        }
        self.report_unclosed_at_end();
        self.close_all();
        Tree { entries: self.top, truncated: self.comment_unclosed }
    }

    /// Takes the next token.
    pub(super) fn advance(&mut self) -> Token {
        let following = self.lexer.next_token();
        let token = std::mem::replace(&mut self.next, following);
        self.cut_closer();
        token
    }

    pub(super) fn span(&self, range: Range<usize>) -> Span {
        Span { source: self.source, start: range.start, end: range.end }
    }

    pub(super) fn word_at(&self, range: Range<usize>) -> Word<'a> {
        Word { text: &self.text[range.clone()], span: self.span(range) }
    }

    pub(super) fn push_number(&mut self, number: Number<'a>) {
        let depth = self.stack.len();
        self.entries(depth).push(Entry::Number(number));
    }

    pub(super) fn push_item(&mut self, keyword: Word<'a>, form: Form<'a>) {
        let depth = self.stack.len();
        self.push_item_at(depth, keyword, form);
    }

    pub(super) fn push_item_at(&mut self, depth: usize, keyword: Word<'a>, form: Form<'a>) {
        self.entries(depth).push(Entry::Item(Item { keyword, form }));
        if let Some(i) = depth.checked_sub(1) {
            self.stack[i].has_items = true;
            self.stack[i].unopened = false;
        }
    }

    /// What the block at some depth holds so far; 0 is the top of the scene.
    pub(super) fn entries(&mut self, depth: usize) -> &mut Vec<Entry<'a>> {
        match depth.checked_sub(1) {
            Some(i) => &mut self.stack[i].block.entries,
            None => &mut self.top,
        }
    }

    pub(super) fn word(&mut self, word: Word<'a>) {
        if self.is_foreign(word) {
            return;
        }
        let is_name = self.next.kind == TokenKind::Open && !self.is_swapped_ahead();
        if looks_like_number(word.text) && !is_name {
            let word = self.cut_number(word);
            let value = self.number(word);
            return self.push_number(Number { word, value });
        }
        if self.closes_as_bracket(word) {
            return;
        }
        let word = self.cut_at_bracket(word);
        self.close_up_to_owner(word);
        let follows = self.follows(self.stack.len(), word.text);
        if follows.is_some_and(|follows| follows != Follows::Element) {
            self.skip_sign(word);
        }
        if !matches!(follows, Some(Follows::Element | Follows::Name | Follows::Value)) {
            self.take_bracket();
        }
        if follows == Some(Follows::Vector) && self.skip_hex_color(word.span.end) {
            return self.push_item(word, Form::Broken);
        }
        let head = Head { keyword: word, name: None };
        match self.next.kind {
            TokenKind::Open => self.open(head),
            TokenKind::Word if !self.lacks_value(word) => self.two_words(word),
            TokenKind::Close if self.is_open_meant(word.text, follows) => self.open_swapped(head),
            _ => self.push_item(word, Form::Nothing),
        }
        self.misplaced = None;
    }

    /// What follows a word in the block at some depth; 0 is the top of the scene.
    pub(super) fn follows(&self, depth: usize, word: &str) -> Option<Follows> {
        let owner = depth.checked_sub(1).map(|i| self.stack[i].owner());
        self.grammar.follows(owner, word)
    }

    pub(super) fn number(&mut self, word: Word<'a>) -> Option<f64> {
        parse_number(word.text)
            .map_err(|e| {
                let fault = e.message.replacen(word.text, "", 1);
                if !(fault.contains(": ") && self.repeats(&fault)) {
                    let diagnostic = Diagnostic { help: e.help, ..Diagnostic::error(e.message) };
                    self.diagnostics.push(diagnostic.at(word.span, ""));
                }
            })
            .ok()
    }

    /// Whether the last faulty word in this block had the same fault: whoever writes commas
    /// writes them throughout.
    pub(super) fn repeats(&mut self, fault: &str) -> bool {
        let Some(frame) = self.stack.last_mut() else { return false };
        frame.word_fault.replace(fault.to_owned()).is_some_and(|last| last == fault)
    }

    /// Whether what follows a word can't be its value: something else that belongs here,
    /// or, at the top of the scene, which has no values, a word on another line.
    pub(super) fn lacks_value(&self, word: Word<'_>) -> bool {
        let depth = self.stack.len();
        let follows = self.follows(depth, word.text);
        let is_below = || self.text[word.span.end..self.next.range.start].contains('\n');
        if depth == 0 && follows.is_none() {
            return is_below();
        }
        let next = &self.text[self.next.range.clone()];
        if depth == 0 && follows == Some(Follows::Name) && self.follows(0, next).is_some() {
            return is_below();
        }
        let may_be_any = follows.is_some_and(|f| f.is_name() || f == Follows::Element);
        !may_be_any && self.follows(depth, next).is_some()
    }

    pub(super) fn two_words(&mut self, keyword: Word<'a>) {
        let follows = self.follows(self.stack.len(), keyword.text);
        let next = &self.text[self.next.range.clone()];
        let belongs_in_block = self.grammar.follows(Some(keyword.text), next).is_some();
        let is_block = match follows {
            Some(Follows::Block) => belongs_in_block,
            Some(Follows::NameOrBlock) => belongs_in_block && self.is_value_behind(),
            _ => false,
        };
        if is_block {
            return self.open_without_brace(Head { keyword, name: None });
        }
        if follows == Some(Follows::Value) {
            self.cut_next_number();
        }
        let range = self.advance().range;
        let mut second = self.word_at(range);
        let is_name = follows.is_some_and(Follows::is_name);
        if follows == Some(Follows::Element) || self.stack.is_empty() && !is_name {
            second = self.cut_name(second);
            second = self.take_name(keyword, second);
            self.take_bracket();
        }
        if is_name {
            second = self.take_value(keyword, second);
        }
        let is_value = is_name || follows == Some(Follows::Value);
        if follows != Some(Follows::Value) {
            match self.unquoted(second) {
                Some(name) => second = name,
                None if is_value => return self.push_item(keyword, Form::Broken),
                None => {}
            }
        }
        let head = Head { keyword, name: Some(second) };
        if self.next.kind == TokenKind::Open && !(is_value && self.is_swapped_ahead()) {
            self.open(head);
        } else if !is_name && self.is_open_meant(keyword.text, follows) {
            self.open_swapped(head);
        } else if follows == Some(Follows::Element) {
            if !self.element_without_block(keyword, second) {
                self.open_without_brace(head);
            }
        } else {
            self.push_item(keyword, Form::Value(second));
            if let Some(frame) = self.stack.last_mut() {
                frame.unopened = follows == Some(Follows::Vector);
            }
        }
    }

    pub(super) fn open(&mut self, head: Head<'a>) {
        let range = self.advance().range;
        let open = self.span(range);
        if self.stack.len() < MAX_DEPTH {
            self.push(Some(head), open);
            self.skip_color_in_braces(open);
        } else {
            self.skip_block(open);
        }
    }

    /// Passes over a colour in hexadecimal digits that stands in a vector just opened.
    pub(super) fn skip_color_in_braces(&mut self, open: Span) {
        let outer = self.stack.len() - 1;
        let owner = self.stack[outer].owner();
        let is_vector = self.follows(outer, owner) == Some(Follows::Vector);
        if is_vector && self.skip_hex_color(open.end) {
            self.stack[outer].block.damaged = true;
        }
    }

    pub(super) fn open_nameless(&mut self, open: Span) {
        if let Some(frame) = self.stack.last_mut().filter(|frame| frame.block.entries.is_empty()) {
            frame.doubled += 1;
            if frame.doubled == 1 && frame.head.is_some() {
                let error = Diagnostic::error("unexpected `{`").at(open, "one too many");
                self.diagnostics.push(error);
            }
            return;
        }
        if self.is_close_meant() {
            self.report_swapped("}", "{", open);
            return self.pop(open);
        }
        let error = Diagnostic::error("expected a name in front of `{`").at(open, "");
        self.diagnostics.push(error);
        if self.stack.len() < MAX_DEPTH {
            self.push(None, open);
        } else {
            self.skip_block(open);
        }
    }

    pub(super) fn open_without_brace(&mut self, head: Head<'a>) {
        let last = head.name.unwrap_or(head.keyword);
        let message = format!("expected `{{` after `{}`", head.title());
        self.diagnostics.push(Diagnostic::error(message).at(last.span, "expected `{` after this"));
        self.push(Some(head), self.span(last.span.end..last.span.end));
    }

    /// Opens a block with a `}` that was meant to be `{`.
    pub(super) fn open_swapped(&mut self, head: Head<'a>) {
        let range = self.advance().range;
        let open = self.span(range);
        self.report_swapped("{", "}", open);
        self.push(Some(head), open);
    }

    pub(super) fn report_swapped(&mut self, expected: &str, found: &str, span: Span) {
        let message = format!("expected `{expected}`, found `{found}`");
        self.diagnostics.push(Diagnostic::error(message).at(span, ""));
    }

    pub(super) fn push(&mut self, head: Option<Head<'a>>, open: Span) {
        let block = Block { open, close: open, entries: Vec::new(), damaged: false };
        let (closer, home) = (self.closer.take(), self.misplaced.take());
        let (has_items, doubled, unopened) = (false, 0, false);
        let word_fault = None;
        let frame = Frame { head, block, has_items, doubled, unopened, closer, home, word_fault };
        self.stack.push(frame);
        self.cut_closer();
    }

    /// Skips a block that is nested too deeply.
    pub(super) fn skip_block(&mut self, open: Span) {
        self.diagnostics.push(
            Diagnostic::error(format!("blocks are nested more than {MAX_DEPTH} deep"))
                .at(open, "this block is skipped"),
        );
        let mut depth = 1;
        while depth > 0 && !matches!(self.next.kind, TokenKind::End | TokenKind::UnclosedComment) {
            match self.advance().kind {
                TokenKind::Open => depth += 1,
                TokenKind::Close => depth -= 1,
                _ => {}
            }
        }
    }

    pub(super) fn pop(&mut self, close: Span) {
        let Some(Frame { head, mut block, home, .. }) = self.stack.pop() else { return };
        block.close = close;
        block.entries.shrink_to_fit();
        let Some(Head { keyword, name }) = head else { return };
        let form = match name {
            Some(name) => Form::Element(name, Box::new(block)),
            None => Form::Block(Box::new(block)),
        };
        self.push_item_at(home.unwrap_or(self.stack.len()), keyword, form);
    }

    pub(super) fn report_comment(&mut self, span: Span) {
        self.comment_unclosed = true;
        self.diagnostics.push(
            Diagnostic::error("this comment is never closed")
                .at(span, "")
                .help("a comment that begins with `/*` ends with `*/`"),
        );
    }
}
