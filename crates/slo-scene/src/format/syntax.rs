//! The syntax tree of a scene: what was written, with places, and nothing of what it means.

use crate::diagnostics::Span;

/// A run of characters of the text; of a name in double quotes, what stands between them.
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
    /// Finite; `None` if the word is no number, which the parser has reported.
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

/// The three forms. Blocks lie apart, so that a number takes little more than its word.
#[derive(Clone, Debug)]
pub enum Form<'a> {
    /// `<type> <name> { ... }`
    Element(Word<'a>, Box<Block<'a>>),
    /// `<name> { ... }`
    Block(Box<Block<'a>>),
    /// `<name> <value>`
    Value(Word<'a>),
    /// `<name>` alone, where a value should follow.
    Nothing,
    /// `<name>` and something that is no value, which the parser has reported.
    Broken,
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

/// What the language allows, and where. It never changes what a correct text means; it tells the parser
/// where a missing brace should have been.
pub trait Grammar {
    /// What follows a word that may begin something in the block of `owner` (`None`: at the top of a
    /// scene); `None` if it may not.
    fn follows(&self, owner: Option<&str>, word: &str) -> Option<Follows>;
}

/// What follows the first word of an element or attribute.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Follows {
    /// A name and a block.
    Element,
    /// A block.
    Block,
    /// Numbers in braces.
    Vector,
    /// A word of the user's own, which may be any.
    Name,
    /// A word of the user's own, or a block.
    NameOrBlock,
    /// A number, or one of several words.
    Value,
}

impl Follows {
    /// Whether a brace may follow at once.
    pub fn is_block(self) -> bool {
        matches!(self, Self::Block | Self::Vector | Self::NameOrBlock)
    }

    /// Whether a word of the user's own may follow at once, which is not the name of a block.
    pub fn is_name(self) -> bool {
        matches!(self, Self::Name | Self::NameOrBlock)
    }
}
