//! The syntax tree of a scene: what was written, with places, and nothing of what it means.

use crate::diagnostics::Span;

/// A run of characters of the text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Word<'a> {
    /// As written.
    pub text: &'a str,
    /// Where.
    pub span: Span,
}

/// A scene text.
#[derive(Clone, Debug)]
pub struct Tree<'a> {
    /// What stands at the top, in the order of the text.
    pub entries: Vec<Entry<'a>>,
    /// Whether the end of the text is lost in a comment that is never closed.
    pub truncated: bool,
}

/// What stands in a block, or at the top of a scene.
#[derive(Clone, Debug)]
pub enum Entry<'a> {
    /// A number by itself, as in a vector.
    Number(Number<'a>),
    /// An element or attribute.
    Item(Item<'a>),
}

/// A number by itself.
#[derive(Clone, Copy, Debug)]
pub struct Number<'a> {
    /// As written.
    pub word: Word<'a>,
    /// Finite; `None` where the word is no number, which the parser has reported.
    pub value: Option<f64>,
}

/// An element or attribute.
#[derive(Clone, Debug)]
pub struct Item<'a> {
    /// Its first word: the type of an element or the name of an attribute.
    pub keyword: Word<'a>,
    /// What follows.
    pub form: Form<'a>,
}

/// The three forms.
#[derive(Clone, Debug)]
pub enum Form<'a> {
    /// `<type> <name> { ... }`
    Element(Word<'a>, Block<'a>),
    /// `<name> { ... }`
    Block(Block<'a>),
    /// `<name> <value>`
    Value(Word<'a>),
    /// `<name>` alone, where a value should follow.
    Nothing,
}

/// What stands between braces.
#[derive(Clone, Debug)]
pub struct Block<'a> {
    /// The `{`.
    pub open: Span,
    /// The `}`, or where it should be.
    pub close: Span,
    /// In the order of the text.
    pub entries: Vec<Entry<'a>>,
    /// Whether braces are wrong in it or about it, so that what seems to be missing may stand
    /// elsewhere. The parser has reported it.
    pub damaged: bool,
}

/// Words of the language. They never change what a correct text means; they tell the parser where
/// a missing brace should have been.
#[derive(Clone, Copy, Debug)]
pub struct Vocabulary<'a> {
    /// Types of elements that stand in no other element.
    pub elements: &'a [&'a str],
    /// Names of attributes and types of inner elements.
    pub attributes: &'a [&'a str],
    /// Those of `attributes` that take a name of the user's own, which may be any word.
    pub naming: &'a [&'a str],
}
