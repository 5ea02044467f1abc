//! What an element takes: its attributes.

use crate::names::is_same;
use crate::settings::{Entry, Form};

/// An element or inner block: its keyword and what may stand in it.
#[derive(Debug)]
pub(crate) struct Schema {
    pub(crate) keyword: &'static str,
    own: &'static [Attribute],
    /// What all elements of its sort take.
    common: &'static [Attribute],
}

impl Schema {
    /// An element with attributes of its own.
    pub(crate) const fn new(keyword: &'static str, own: &'static [Attribute]) -> Self {
        Self { keyword, own, common: &[] }
    }

    /// The element with the attributes that all elements of its sort take, too.
    pub(crate) const fn with(self, common: &'static [Attribute]) -> Self {
        Self { common, ..self }
    }

    /// All attributes, in the order of messages.
    pub(crate) fn attributes(&self) -> impl Iterator<Item = &'static Attribute> + use<> {
        self.words().filter(|attribute| !matches!(attribute.kind, Kind::Absent(_)))
    }

    /// All words that mean something here, even if they can't be used.
    fn words(&self) -> impl Iterator<Item = &'static Attribute> + use<> {
        self.own.iter().chain(self.common)
    }

    /// What to say about a word that the element does not take yet.
    pub(crate) fn absent(&self, name: &str) -> Option<&'static str> {
        self.words().find_map(|word| match word.kind {
            Kind::Absent(help) if is_same(word.name, name) || word.is_called(name) => Some(help),
            _ => None,
        })
    }

    /// The attribute that other programs and formats call so.
    pub(crate) fn called(&self, name: &str) -> Option<&'static Attribute> {
        self.attributes().find(|attribute| attribute.is_called(name))
    }

    /// The attribute of a name.
    pub(crate) fn attribute(&self, name: &str) -> Option<&'static Attribute> {
        self.attributes().find(|attribute| attribute.name == name)
    }
}

/// What may stand in an element.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Attribute {
    pub(crate) name: &'static str,
    pub(crate) kind: Kind,
    pub(crate) required: bool,
    pub(crate) repeated: bool,
    /// What other programs and formats call it.
    pub(crate) elsewhere: &'static [&'static str],
}

/// What an attribute takes.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Kind {
    /// A number.
    Number,
    /// One of several words.
    Choice,
    /// A word of the user's own: a name, a path; with how to call it.
    Word(&'static str),
    /// Three numbers in braces; with how to call them.
    Vector(&'static str),
    /// One number in braces; with how to call it.
    Single(&'static str),
    /// Attributes in braces.
    Block(&'static Schema),
    /// A name, and attributes in braces.
    Element(&'static Schema),
    /// A word of the user's own, or attributes in braces; with how to call the word.
    WordOrBlock(&'static str, &'static Schema),
    /// Nothing: the language does not have it yet. With what to say to whoever writes it.
    Absent(&'static str),
}

impl Attribute {
    pub(crate) const fn new(name: &'static str, kind: Kind) -> Self {
        Self { name, kind, required: false, repeated: false, elsewhere: &[] }
    }

    pub(crate) const fn required(self) -> Self {
        Self { required: true, ..self }
    }

    pub(crate) const fn repeated(self) -> Self {
        Self { repeated: true, ..self }
    }

    pub(crate) const fn elsewhere(self, names: &'static [&'static str]) -> Self {
        Self { elsewhere: names, ..self }
    }

    /// Whether other programs and formats call it so.
    fn is_called(&self, name: &str) -> bool {
        self.elsewhere.iter().any(|other| is_same(other, name))
    }

    /// How to write it.
    pub(crate) fn usage(&self) -> String {
        let name = self.name;
        match self.kind {
            Kind::Number => format!("`{name} NUMBER`"),
            Kind::Choice => format!("`{name} WORD`"),
            Kind::Word(what) => format!("`{name} {what}`"),
            Kind::Vector(what) | Kind::Single(what) => format!("`{name} {{ {what} }}`"),
            Kind::Block(_) => format!("`{name} {{ ... }}`"),
            Kind::Element(_) => format!("`{name} NAME {{ ... }}`"),
            Kind::WordOrBlock(what, _) => format!("`{name} {what}` or `{name} {{ ... }}`"),
            Kind::Absent(_) => String::new(),
        }
    }
}

/// A number.
pub(crate) const fn number(name: &'static str) -> Attribute {
    Attribute::new(name, Kind::Number)
}

/// A position or direction.
pub(crate) const fn point(name: &'static str) -> Attribute {
    Attribute::new(name, Kind::Vector("x y z"))
}

/// A number in braces.
pub(crate) const fn single(name: &'static str, what: &'static str) -> Attribute {
    Attribute::new(name, Kind::Single(what))
}

/// Red, green, blue.
pub(crate) const fn color(name: &'static str) -> Attribute {
    Attribute::new(name, Kind::Vector("r g b"))
}

/// A word of the user's own.
pub(crate) const fn word(name: &'static str, what: &'static str) -> Attribute {
    Attribute::new(name, Kind::Word(what))
}

/// One of several words.
pub(crate) const fn choice(name: &'static str) -> Attribute {
    Attribute::new(name, Kind::Choice)
}

/// A word of the user's own or a block, called by the keyword of the block's schema.
pub(crate) const fn word_or_block(what: &'static str, schema: &'static Schema) -> Attribute {
    Attribute::new(schema.keyword, Kind::WordOrBlock(what, schema))
}

/// A word that the element does not take yet; with what to say about it.
pub(crate) const fn absent(name: &'static str, help: &'static str) -> Attribute {
    Attribute::new(name, Kind::Absent(help))
}

/// A block, called by the keyword of its schema.
pub(crate) const fn block(schema: &'static Schema) -> Attribute {
    Attribute::new(schema.keyword, Kind::Block(schema))
}

/// An element in another one, called by the keyword of its schema.
pub(crate) const fn inner(schema: &'static Schema) -> Attribute {
    Attribute::new(schema.keyword, Kind::Element(schema))
}

/// The attributes of an element that is a list of settings.
pub(crate) const fn attributes<S, const N: usize>(entries: &[Entry<S>]) -> [Attribute; N] {
    let mut attributes = [Attribute::new("", Kind::Number); N];
    let mut i = 0;
    while i < N {
        let entry = &entries[i];
        let kind = match entry.form {
            Form::Flag | Form::Count(..) | Form::Whole | Form::Single(_) | Form::Double(_) => {
                Kind::Number
            }
            Form::Color => Kind::Vector("r g b"),
            Form::Word(_) => Kind::Choice,
            Form::Text(what) => Kind::Word(what),
        };
        attributes[i] =
            Attribute { required: entry.is_required, ..Attribute::new(entry.name, kind) };
        i += 1;
    }
    attributes
}
