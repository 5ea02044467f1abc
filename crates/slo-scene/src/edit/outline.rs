//! The elements of a text.

use super::part::Part;
use crate::attributes::INCLUDE;
use crate::diagnostics::{Diagnostics, SourceId};
use crate::format::parse;
use crate::format::syntax::{Entry, Form, Tree};
use crate::resolve::LANGUAGE;

/// The elements of a text, with their places.
#[derive(Clone, Debug)]
pub struct Outline<'a> {
    text: &'a str,
    tree: Tree<'a>,
}

impl<'a> Outline<'a> {
    /// The elements of a text, as far as it can be read. It must not begin with a byte order mark.
    pub fn new(text: &'a str) -> Self {
        let tree = parse(text, SourceId(0), &*LANGUAGE, &mut Diagnostics::default());
        Self { text, tree }
    }

    /// All elements at the top, in order; without those of included files.
    pub fn elements(&self) -> impl Iterator<Item = Part<'_, 'a>> {
        self.tree.entries.iter().filter_map(|entry| match entry {
            Entry::Item(item) => Part::of(self.text, item),
            Entry::Number(_) => None,
        })
    }

    /// The paths of the files that it includes, in order.
    pub fn includes(&self) -> impl Iterator<Item = &'a str> {
        self.tree.entries.iter().filter_map(|entry| match entry {
            Entry::Item(item) if item.keyword.text == INCLUDE => match item.form {
                Form::Value(path) => Some(path.text),
                _ => None,
            },
            _ => None,
        })
    }

    /// The element of a kind with a name.
    pub fn element(&self, keyword: &str, name: &str) -> Option<Part<'_, 'a>> {
        self.elements().find(|part| part.keyword() == keyword && part.name() == Some(name))
    }

    /// The first element of a kind.
    pub fn first(&self, keyword: &str) -> Option<Part<'_, 'a>> {
        self.elements().find(|part| part.keyword() == keyword)
    }
}
