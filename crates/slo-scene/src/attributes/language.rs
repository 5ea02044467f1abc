//! All elements of the language.

use super::schema::{Kind, Schema};
use crate::format::syntax::{Follows, Grammar};

/// The word at the top of a scene that a path follows.
pub(crate) const INCLUDE: &str = "include";

/// The elements that may stand at the top of a scene, and those inside them.
#[derive(Debug)]
pub(crate) struct Language {
    elements: Vec<&'static Schema>,
    /// Elements and blocks that stand only in others.
    inner: Vec<&'static Schema>,
}

impl Language {
    /// The language of these elements, in the order of messages, and of all that stands in them.
    pub(crate) fn new(elements: Vec<&'static Schema>) -> Self {
        let mut language = Self { elements: elements.clone(), inner: Vec::new() };
        elements.into_iter().for_each(|schema| language.add_inner(schema));
        language
    }

    fn add_inner(&mut self, schema: &'static Schema) {
        for attribute in schema.attributes() {
            if let Kind::Block(inner) | Kind::Element(inner) | Kind::WordOrBlock(_, inner) =
                attribute.kind
                && !self.inner.iter().any(|known| known.keyword == inner.keyword)
            {
                self.inner.push(inner);
                self.add_inner(inner);
            }
        }
    }

    /// Keywords of the elements at the top of a scene.
    pub(crate) fn keywords(&self) -> impl Iterator<Item = &'static str> + Clone {
        self.elements.iter().map(|schema| schema.keyword)
    }

    /// Whether a word begins an element at the top of a scene.
    pub(crate) fn has_element(&self, word: &str) -> bool {
        self.keywords().any(|keyword| keyword == word)
    }

    /// Keywords of the elements and blocks that take an attribute of that name.
    pub(crate) fn owners(&self, name: &str) -> Vec<&'static str> {
        let owners = self.all().filter(|schema| schema.attribute(name).is_some());
        owners.map(|schema| schema.keyword).collect()
    }

    /// All elements and blocks.
    pub(crate) fn all(&self) -> impl Iterator<Item = &'static Schema> {
        self.elements.iter().chain(&self.inner).copied()
    }
}

impl Grammar for Language {
    fn follows(&self, owner: Option<&str>, word: &str) -> Option<Follows> {
        let Some(owner) = owner else {
            if word == INCLUDE {
                return Some(Follows::Name);
            }
            return self.has_element(word).then_some(Follows::Element);
        };
        let schema = self.all().find(|schema| schema.keyword == owner)?;
        Some(match schema.attribute(word)?.kind {
            Kind::Element(_) => Follows::Element,
            Kind::Block(_) => Follows::Block,
            Kind::Vector(_) | Kind::Single(_) => Follows::Vector,
            Kind::Word(_) => Follows::Name,
            Kind::WordOrBlock(..) => Follows::NameOrBlock,
            Kind::Number | Kind::Choice => Follows::Value,
            Kind::Absent(_) => return None,
        })
    }
}
