//! An element or a block, and the changes that can be made to it.

use std::ops::Range;

use super::Edit;
use super::layout;
use crate::diagnostics::Span;
use crate::format::parse_number;
use crate::format::syntax::{Block, Entry, Form, Item, Word};

/// An element or a block within one.
#[derive(Clone, Copy, Debug)]
pub struct Part<'t, 'a> {
    text: &'a str,
    item: &'t Item<'a>,
    block: &'t Block<'a>,
}

impl<'t, 'a> Part<'t, 'a> {
    /// `None` if it has no braces, or lacks one of them: it is not known then where it ends.
    pub(super) fn of(text: &'a str, item: &'t Item<'a>) -> Option<Self> {
        let (Form::Element(_, block) | Form::Block(block)) = &item.form else { return None };
        let is = |span: Span, brace| text.get(span.start..span.end) == Some(brace);
        let is_whole = is(block.open, "{")
            && is(block.close, "}")
            && item.keyword.span.end <= block.open.start
            && block.open.end <= block.close.start;
        is_whole.then_some(Self { text, item, block })
    }

    /// Its first word.
    pub fn keyword(&self) -> &'a str {
        self.item.keyword.text
    }

    /// Its name; `None` if it is a block.
    pub fn name(&self) -> Option<&'a str> {
        match &self.item.form {
            Form::Element(name, _) => Some(name.text),
            _ => None,
        }
    }

    /// The bytes from its first word to its brace.
    pub fn range(&self) -> Range<usize> {
        self.item.keyword.span.start..self.block.close.end
    }

    /// The bytes of its name, with its quotes; `None` if it is a block.
    pub fn name_range(&self) -> Option<Range<usize>> {
        match &self.item.form {
            Form::Element(name, _) => Some(whole(self.text, *name)),
            _ => None,
        }
    }

    /// The bytes from its first word to its brace, with the comments right above it and behind it.
    pub fn with_comments(&self) -> Range<usize> {
        layout::with_comments(self.text, self.range())
    }

    /// Its line, from 1.
    pub fn line(&self) -> usize {
        self.text[..self.item.keyword.span.start].matches('\n').count() + 1
    }

    /// The blocks and elements of a kind within it, in order.
    pub fn parts(&self, keyword: &str) -> impl Iterator<Item = Part<'t, 'a>> {
        self.items(keyword).filter_map(|item| Self::of(self.text, item))
    }

    /// The first of them.
    pub fn part(&self, keyword: &str) -> Option<Part<'t, 'a>> {
        self.parts(keyword).next()
    }

    /// Names of everything that stands in it, in order.
    pub fn names(&self) -> impl Iterator<Item = &'a str> {
        self.block.entries.iter().filter_map(|entry| match entry {
            Entry::Item(item) => Some(item.keyword.text),
            Entry::Number(_) => None,
        })
    }

    /// The value of an attribute: its word, or what stands between its braces.
    pub fn value(&self, name: &str) -> Option<&'a str> {
        let item = self.items(name).next()?;
        match &item.form {
            Form::Value(word) => Some(word.text),
            _ => Some(self.text[Self::of(self.text, item)?.inside()].trim()),
        }
    }

    /// The numbers of an attribute: one, or those between its braces.
    pub fn numbers(&self, name: &str) -> Option<Vec<f64>> {
        numbers_of(self.items(name).next()?)
    }

    /// The numbers that stand directly in it.
    pub fn own_numbers(&self) -> Option<Vec<f64>> {
        numbers_of(self.item)
    }

    /// Gives an attribute a value: numbers and words as they stand in a scene, without braces. An attribute
    /// that is missing is added.
    pub fn set(&self, name: &str, value: &str) -> Vec<Edit> {
        self.set_one(name, 0, value)
    }

    /// The same for one of several attributes of the same name.
    pub fn set_one(&self, name: &str, index: usize, value: &str) -> Vec<Edit> {
        let Some(item) = self.items(name).nth(index) else {
            return vec![self.add(&format!("{name} {value}"))];
        };
        match &item.form {
            Form::Value(word) => replaced(self.text, *word, value).into_iter().collect(),
            Form::Block(block) => self.refilled(item, block, value),
            _ => Vec::new(),
        }
    }

    /// The same for an attribute that is a vector: its braces are added with it.
    pub fn set_vector(&self, name: &str, value: &str) -> Vec<Edit> {
        match self.items(name).next() {
            Some(_) => self.set(name, value),
            None => vec![self.add(&format!("{name} {{ {value} }}"))],
        }
    }

    /// Adds something behind everything that stands in it.
    pub fn add(&self, what: &str) -> Edit {
        let last = self.block.entries.last().map(|entry| self.end_of(entry));
        let last = last.filter(|last| (self.inside().start..=self.inside().end).contains(last));
        layout::add(self.text, self.block.open.end, last, self.block.close.start, what)
    }

    /// Adds something on a line of its own behind it.
    pub fn follow(&self, what: &str) -> Edit {
        layout::follow(self.text, &self.range(), what)
    }

    /// Takes it out, with its line if nothing else stands there.
    pub fn remove(&self) -> Edit {
        layout::remove(self.text, self.range())
    }

    /// Takes out attributes of a name, but for the first so many of them.
    pub fn without(&self, name: &str, kept: usize) -> Vec<Edit> {
        let entries = self.block.entries.iter().filter(|entry| match entry {
            Entry::Item(item) => item.keyword.text == name,
            Entry::Number(_) => false,
        });
        let taken = entries.skip(kept).filter_map(|entry| match entry {
            Entry::Item(item) => {
                let range = item.keyword.span.start..self.end_of(entry);
                self.text.get(range.clone()).map(|_| layout::remove_word(self.text, range))
            }
            Entry::Number(_) => None,
        });
        taken.collect()
    }

    pub(super) fn text(&self) -> &'a str {
        self.text
    }

    pub(super) fn block(&self) -> &'t Block<'a> {
        self.block
    }

    fn inside(&self) -> Range<usize> {
        self.block.open.end..self.block.close.start
    }

    fn items(&self, name: &str) -> impl Iterator<Item = &'t Item<'a>> {
        self.block.entries.iter().filter_map(move |entry| match entry {
            Entry::Item(item) if item.keyword.text == name => Some(item),
            _ => None,
        })
    }

    /// Changes what stands in a block of numbers: only those that differ, if there are as many.
    fn refilled(&self, item: &'t Item<'a>, block: &'t Block<'a>, value: &str) -> Vec<Edit> {
        let Some(inner) = Self::of(self.text, item) else { return Vec::new() };
        let words: Vec<&str> = value.split_whitespace().collect();
        let old: Vec<Word<'a>> = block
            .entries
            .iter()
            .filter_map(|entry| match entry {
                Entry::Number(number) => Some(number.word),
                Entry::Item(_) => None,
            })
            .collect();
        if old.len() == words.len() && old.len() == block.entries.len() {
            let pairs = old.into_iter().zip(words);
            return pairs.filter_map(|(old, new)| replaced(self.text, old, new)).collect();
        }
        vec![Edit { range: inner.inside(), text: format!(" {value} ") }]
    }

    fn end_of(&self, entry: &Entry<'a>) -> usize {
        match entry {
            Entry::Number(number) => number.word.span.end,
            Entry::Item(item) => match &item.form {
                Form::Element(_, block) | Form::Block(block) => block.close.end,
                Form::Value(word) => whole(self.text, *word).end,
                Form::Nothing | Form::Broken => item.keyword.span.end,
            },
        }
    }
}

/// The numbers of an attribute.
fn numbers_of(item: &Item<'_>) -> Option<Vec<f64>> {
    match &item.form {
        Form::Value(word) => Some(vec![parse_number(word.text).ok()?]),
        Form::Block(block) | Form::Element(_, block) => {
            let numbers = block.entries.iter().map(|entry| match entry {
                Entry::Number(number) => number.value,
                Entry::Item(_) => None,
            });
            numbers.collect()
        }
        Form::Nothing | Form::Broken => None,
    }
}

/// Replaces a word, unless it means the same number already.
fn replaced(text: &str, old: Word<'_>, new: &str) -> Option<Edit> {
    let is_same = match (parse_number(old.text), parse_number(new)) {
        (Ok(old), Ok(new)) => old == new,
        _ => old.text == new,
    };
    (!is_same).then(|| Edit { range: whole(text, old), text: new.to_owned() })
}

/// The bytes of a word, with its quotes.
pub(super) fn whole(text: &str, word: Word<'_>) -> Range<usize> {
    let Range { start, end } = word.span.start..word.span.end;
    let is_quoted = start > 0
        && text.as_bytes().get(start - 1) == Some(&b'"')
        && text.as_bytes().get(end) == Some(&b'"');
    if is_quoted { start - 1..end + 1 } else { start..end }
}
