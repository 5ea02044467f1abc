//! The elements at the top of a scene, by type.

use super::fields::{Element, nameless};
use super::schema::{ELEMENTS, owners};
use super::{AllNames, quoted_list};
use crate::diagnostics::{Diagnostic, Diagnostics};
use crate::format::syntax::{Entry, Form, Item, Tree, Word};
use crate::names::{Names, closest, invisible};

/// Elements that can be seen, in the order of messages.
const OBJECTS: [&str; 8] =
    ["plane", "sphere", "triangle", "rectangle", "box", "cylinder", "cone", "mesh"];

/// Elements without positions; everything else is scaled.
const UNSCALED: [&str; 6] =
    ["Scaling", "settings", "phong_info", "material_phong", "texture", "material_texture"];

/// The elements of a scene in the order of the text.
pub(super) struct Scene<'t, 'a> {
    elements: Vec<Element<'t, 'a>>,
    /// Names of elements of unknown types.
    unknown: Vec<Word<'a>>,
    /// Whether the end of the text is lost, so that elements may be.
    pub(super) is_truncated: bool,
}

impl<'t, 'a> Scene<'t, 'a> {
    /// Sorts out what is no element.
    pub(super) fn collect(tree: &'t Tree<'a>, diagnostics: &mut Diagnostics) -> Self {
        let is_truncated = tree.truncated;
        let mut scene = Self { elements: Vec::new(), unknown: Vec::new(), is_truncated };
        let mut in_numbers = false;
        // Of words in a row that mean nothing only the first is reported.
        let mut in_strangers = false;
        for entry in &tree.entries {
            match entry {
                Entry::Item(item) => {
                    in_numbers = !scene.item(item, in_strangers, diagnostics);
                    in_strangers = in_numbers && owners(item.keyword.text).is_empty();
                }
                Entry::Number(number) if !in_numbers && number.value.is_some() => {
                    in_numbers = true;
                    let error = Diagnostic::error("expected an element, found a number");
                    diagnostics.push(error.at(number.word.span, ""));
                }
                Entry::Number(_) => {}
            }
        }
        scene
    }

    /// Whether the item is an element; if not, this was reported.
    fn item(
        &mut self,
        item: &'t Item<'a>,
        in_strangers: bool,
        diagnostics: &mut Diagnostics,
    ) -> bool {
        let keyword = item.keyword;
        let schema = ELEMENTS.iter().find(|s| s.keyword == keyword.text);
        let (name, block) = match &item.form {
            Form::Element(name, block) => (*name, block),
            Form::Block(block) if schema.is_some() => {
                diagnostics.push(nameless(keyword));
                (Word { text: "", span: keyword.span }, block)
            }
            _ => {
                if !in_strangers || !owners(keyword.text).is_empty() {
                    diagnostics.push(not_an_element(item));
                }
                return false;
            }
        };
        // One that is misspelt is taken for what was meant, so that what is in it is looked at too.
        let schema = schema.or_else(|| {
            diagnostics.push(unknown_type(keyword));
            let near = closest(keyword.text, ELEMENTS.iter().map(|s| s.keyword))?;
            ELEMENTS.iter().find(|s| s.keyword == near)
        });
        match schema {
            Some(schema) => {
                let damaged = block.damaged;
                self.elements.push(Element { schema, keyword, name, block, damaged });
            }
            None => self.unknown.push(name),
        }
        true
    }

    /// Whether the scene has no elements at all.
    pub(super) fn is_empty(&self) -> bool {
        self.elements.is_empty()
    }

    /// All elements of some types.
    pub(super) fn of(&self, keywords: &[&str]) -> Vec<Element<'t, 'a>> {
        let elements = self.elements.iter();
        elements.filter(|e| keywords.contains(&e.schema.keyword)).copied().collect()
    }

    /// All that can be seen.
    pub(super) fn objects(&self) -> Vec<Element<'t, 'a>> {
        self.of(&OBJECTS)
    }

    /// The first element that `Scaling` changes.
    pub(super) fn first_with_positions(&self) -> Option<&Element<'t, 'a>> {
        self.elements.iter().find(|e| !UNSCALED.contains(&e.schema.keyword))
    }

    /// The one element of a type; reports all but the first.
    pub(super) fn only(
        &self,
        keyword: &str,
        diagnostics: &mut Diagnostics,
    ) -> Option<Element<'t, 'a>> {
        let elements = self.of(&[keyword]);
        let (first, others) = elements.split_first()?;
        for other in others {
            diagnostics.push(
                Diagnostic::error(format!("the scene has more than one `{keyword}`"))
                    .at(other.head(), "one too many")
                    .also(first.head(), "first here"),
            );
        }
        Some(*first)
    }

    /// What can be referred to; reports names that are given twice.
    pub(super) fn names(&self, diagnostics: &mut Diagnostics) -> AllNames<'a> {
        let mut unknown = Names::new("element");
        self.unknown.iter().for_each(|word| _ = unknown.declare(*word));
        let lights = ["light_point", "light_rectangle"];
        self.warn_of_doubles("light", &lights, diagnostics);
        self.warn_of_doubles("object", &OBJECTS, diagnostics);
        AllNames {
            phong_infos: self.declare("phong_info", &["phong_info"], diagnostics),
            materials: self.declare(
                "material",
                &["material_phong", "material_texture"],
                diagnostics,
            ),
            textures: self.declare("texture", &["texture"], diagnostics),
            unknown,
        }
    }

    fn declare(
        &self,
        kind: &'static str,
        keywords: &[&str],
        diagnostics: &mut Diagnostics,
    ) -> Names<'a> {
        let mut names = Names::new(kind);
        for element in self.of(keywords) {
            if let Some(double) = names.declare(element.name) {
                let message = format!("two {kind}s are called `{}`", element.name.text);
                diagnostics.push(
                    Diagnostic::error(message)
                        .at(double.again, "again")
                        .also(double.first, "first here"),
                );
            }
        }
        names
    }

    /// Nothing refers to objects and lights, so their names matter only to people.
    fn warn_of_doubles(
        &self,
        kind: &'static str,
        keywords: &[&str],
        diagnostics: &mut Diagnostics,
    ) {
        let mut names = Names::new(kind);
        for element in self.of(keywords) {
            if let Some(double) = names.declare(element.name) {
                let message = format!("two {kind}s are called `{}`", element.name.text);
                diagnostics.push(
                    Diagnostic::warning(message)
                        .at(double.again, "again")
                        .also(double.first, "first here"),
                );
            }
        }
    }
}

fn unknown_type(keyword: Word<'_>) -> Diagnostic {
    let word = keyword.text;
    let types = ELEMENTS.iter().map(|s| s.keyword);
    if let Some(near) = closest(word, types.clone()) {
        let message = format!("unknown element `{word}`, did you mean `{near}`?");
        let help = invisible(word);
        return Diagnostic { help, ..Diagnostic::error(message).at(keyword.span, "") };
    }
    let diagnostic = Diagnostic::error(format!("unknown element `{word}`"));
    match owners(word).as_slice() {
        [] => diagnostic
            .at(keyword.span, "")
            .help(format!("a scene takes {}", quoted_list(types, usize::MAX))),
        owners => diagnostic
            .at(keyword.span, format!("this stands in {}", quoted_list(owners.iter().copied(), 3))),
    }
}

fn not_an_element(item: &Item<'_>) -> Diagnostic {
    let Item { keyword, form } = item;
    let word = keyword.text;
    if let Form::Block(_) = form
        && owners(word).is_empty()
    {
        return unknown_type(*keyword);
    }
    let diagnostic = Diagnostic::error(format!("expected an element, found `{word}`"));
    match owners(word).as_slice() {
        [] => diagnostic.at(keyword.span, "").help("an element is written `TYPE NAME { ... }`"),
        owners => {
            let list = quoted_list(owners.iter().copied(), 3);
            diagnostic.at(keyword.span, format!("this is an attribute of {list}"))
        }
    }
}
