//! What an element takes: its attributes.

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
        self.own.iter().chain(self.common)
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
    /// Attributes in braces.
    Block(&'static Schema),
    /// A name, and attributes in braces.
    Element(&'static Schema),
}

impl Attribute {
    const fn new(name: &'static str, kind: Kind) -> Self {
        Self { name, kind, required: false, repeated: false }
    }

    pub(crate) const fn required(self) -> Self {
        Self { required: true, ..self }
    }

    pub(crate) const fn repeated(self) -> Self {
        Self { repeated: true, ..self }
    }

    /// How to write it.
    pub(crate) fn usage(&self) -> String {
        let name = self.name;
        match self.kind {
            Kind::Number => format!("`{name} NUMBER`"),
            Kind::Choice => format!("`{name} WORD`"),
            Kind::Word(what) => format!("`{name} {what}`"),
            Kind::Vector(what) => format!("`{name} {{ {what} }}`"),
            Kind::Block(_) => format!("`{name} {{ ... }}`"),
            Kind::Element(_) => format!("`{name} NAME {{ ... }}`"),
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
