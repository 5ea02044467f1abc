//! The elements at the top of a scene, by type.

use super::elements::{ELEMENTS, LANGUAGE, Role};
use super::includes::Trees;
use crate::attributes::{Element, INCLUDE, References, element_meant, nameless, quoted_list};
use crate::diagnostics::{Diagnostic, Diagnostics};
use crate::format::syntax::{Entry, Form, Item, Tree, Word};
use crate::names::{Names, closest, invisible};
use crate::shape::ReadShape;

/// The elements of a scene in the order of the text.
pub(super) struct Scene<'t, 'a> {
    elements: Vec<(Role, Element<'t, 'a>)>,
    /// Names of elements of unknown types.
    unknown: Vec<Word<'a>>,
    /// Whether the end of the text is lost, and perhaps elements with it.
    pub(super) is_truncated: bool,
}

impl<'t, 'a> Scene<'t, 'a> {
    /// Collects the elements; reports everything else.
    pub(super) fn collect(trees: &'t Trees<'a>, diagnostics: &mut Diagnostics) -> Self {
        let is_truncated = trees.is_truncated;
        let mut scene = Self { elements: Vec::new(), unknown: Vec::new(), is_truncated };
        scene.add(&trees.main, trees, diagnostics);
        scene
    }

    /// Adds the elements of a tree and of all that it includes.
    fn add(&mut self, tree: &'t Tree<'a>, trees: &'t Trees<'a>, diagnostics: &mut Diagnostics) {
        let mut in_numbers = false;
        // Of several unknown words in a row only the first is reported.
        let mut in_strangers = false;
        for entry in &tree.entries {
            match entry {
                Entry::Item(item) if item.keyword.text == INCLUDE => {
                    (in_numbers, in_strangers) = (false, false);
                    if let Some(tree) = trees.of(item) {
                        self.add(tree, trees, diagnostics);
                    }
                }
                Entry::Item(item) => {
                    in_numbers = !self.item(item, in_strangers, diagnostics);
                    in_strangers = in_numbers && LANGUAGE.owners(item.keyword.text).is_empty();
                }
                Entry::Number(number) if !in_numbers && number.value.is_some() => {
                    in_numbers = true;
                    let error = Diagnostic::error("expected an element, found a number");
                    diagnostics.push(error.at(number.word.span, ""));
                }
                Entry::Number(_) => {}
            }
        }
    }

    /// Whether one element stands before another.
    pub(super) fn is_before(&self, one: &Element<'t, 'a>, other: &Element<'t, 'a>) -> bool {
        let place = |of: &Element<'t, 'a>| {
            self.elements.iter().position(|(_, e)| e.keyword.span == of.keyword.span)
        };
        place(one) < place(other)
    }

    /// Adds an element. Returns whether the item is one; if not, this was reported.
    fn item(
        &mut self,
        item: &'t Item<'a>,
        in_strangers: bool,
        diagnostics: &mut Diagnostics,
    ) -> bool {
        let keyword = item.keyword;
        let known = ELEMENTS.iter().find(|known| known.schema.keyword == keyword.text);
        let (name, block) = match &item.form {
            Form::Element(name, block) => (*name, block),
            Form::Block(block) if known.is_some() => {
                diagnostics.push(nameless(keyword));
                (Word { text: "", span: keyword.span }, block)
            }
            _ => {
                if !in_strangers || !LANGUAGE.owners(keyword.text).is_empty() {
                    diagnostics.push(not_an_element(item));
                }
                return false;
            }
        };
        // A misspelt element is read as the one that was meant, so that its block is checked too.
        let known = known.or_else(|| {
            diagnostics.push(unknown_type(keyword));
            // Another program's element has other attributes.
            if element_meant(keyword.text).is_some() {
                return None;
            }
            let near = closest(keyword.text, LANGUAGE.keywords())?;
            ELEMENTS.iter().find(|known| known.schema.keyword == near)
        });
        match known {
            Some(known) => {
                let (schema, damaged) = (&known.schema, block.damaged);
                self.elements.push((known.role, Element { schema, keyword, name, block, damaged }));
            }
            None => self.unknown.push(name),
        }
        true
    }

    /// Whether the scene has no elements at all.
    pub(super) fn is_empty(&self) -> bool {
        self.elements.is_empty()
    }

    /// All elements of a role, by what `of` makes of it.
    pub(super) fn of<T>(&self, of: impl Fn(Role) -> Option<T>) -> Vec<(T, Element<'t, 'a>)> {
        self.elements.iter().filter_map(|(role, element)| Some((of(*role)?, *element))).collect()
    }

    /// All objects.
    pub(super) fn objects(&self) -> Vec<(ReadShape, Element<'t, 'a>)> {
        self.of(|role| match role {
            Role::Object(read) => Some(read),
            _ => None,
        })
    }

    /// The first element that `Scaling` changes.
    pub(super) fn first_with_positions(&self) -> Option<&Element<'t, 'a>> {
        let (_, element) = self.elements.iter().find(|(role, _)| role.has_positions())?;
        Some(element)
    }

    /// The one element of a role; reports all but the first.
    pub(super) fn only(
        &self,
        of: impl Fn(Role) -> bool,
        diagnostics: &mut Diagnostics,
    ) -> Option<Element<'t, 'a>> {
        let elements = self.of(|role| of(role).then_some(()));
        let ((_, first), others) = elements.split_first()?;
        for (_, other) in others {
            let keyword = first.schema.keyword;
            diagnostics.push(
                Diagnostic::error(format!("the scene has more than one `{keyword}`"))
                    .at(other.head(), "one too many")
                    .also(first.head(), "first here"),
            );
        }
        Some(*first)
    }

    /// What can be referred to; reports names that are given twice.
    pub(super) fn references(&self, diagnostics: &mut Diagnostics) -> References<'a> {
        let mut references = References::new(&self.unknown, self.is_truncated);
        let [mut lights, mut objects] = ["light", "object"].map(Names::new);
        for (role, element) in &self.elements {
            if let Some(referred) = role.referred() {
                references.declare(referred, element.name, diagnostics);
            }
            match role {
                Role::Light(_) => warn_of_double(&mut lights, element.name, diagnostics),
                Role::Object(_) => warn_of_double(&mut objects, element.name, diagnostics),
                Role::Scaling
                | Role::Settings
                | Role::Camera
                | Role::PhongInfo
                | Role::Material(_)
                | Role::Texture => {}
            }
        }
        references
    }
}

/// Nothing refers to objects and lights, so their names matter only to people.
fn warn_of_double<'a>(names: &mut Names<'a>, name: Word<'a>, diagnostics: &mut Diagnostics) {
    if let Some(double) = names.declare(name) {
        let message = format!("two {}s are called `{}`", names.kind(), name.text);
        let warning = Diagnostic::warning(message).at(double.again, "again");
        diagnostics.push(warning.also(double.first, "first here"));
    }
}

fn unknown_type(keyword: Word<'_>) -> Diagnostic {
    let word = keyword.text;
    let types = LANGUAGE.keywords();
    if let Some(meant) = element_meant(word) {
        let message = format!("unknown element `{word}`, did you mean `{meant}`?");
        return Diagnostic {
            help: usage(meant),
            ..Diagnostic::error(message).at(keyword.span, "")
        };
    }
    if let Some(near) = closest(word, types.clone()) {
        let message = format!("unknown element `{word}`, did you mean `{near}`?");
        let help = invisible(word);
        return Diagnostic { help, ..Diagnostic::error(message).at(keyword.span, "") };
    }
    let diagnostic = Diagnostic::error(format!("unknown element `{word}`"));
    match LANGUAGE.owners(word).as_slice() {
        [] => diagnostic
            .at(keyword.span, "")
            .help(format!("a scene takes {}", quoted_list(types, usize::MAX))),
        owners => diagnostic
            .at(keyword.span, format!("this stands in {}", quoted_list(owners.iter().copied(), 3))),
    }
}

/// How to write an element: its first attribute, and those that it must have.
fn usage(keyword: &str) -> Option<String> {
    let known = ELEMENTS.iter().find(|known| known.schema.keyword == keyword)?;
    let attributes = known.schema.attributes().enumerate();
    let attributes = attributes.filter(|(i, attribute)| *i == 0 || attribute.required);
    let usages: Vec<_> = attributes.map(|(_, attribute)| attribute.usage()).collect();
    Some(format!("write `{keyword} NAME {{ {} }}`", usages.join("  ").replace('`', "")))
}

fn not_an_element(item: &Item<'_>) -> Diagnostic {
    let Item { keyword, form } = item;
    let word = keyword.text;
    if let Form::Block(_) = form
        && LANGUAGE.owners(word).is_empty()
    {
        return unknown_type(*keyword);
    }
    let includes = || closest(word, [INCLUDE, "import"].into_iter()).is_some();
    if matches!(form, Form::Value(_)) && LANGUAGE.owners(word).is_empty() && includes() {
        let message = format!("unknown element `{word}`, did you mean `{INCLUDE}`?");
        return Diagnostic::error(message).at(keyword.span, "").help("write `include PATH`");
    }
    let diagnostic = Diagnostic::error(format!("expected an element, found `{word}`"));
    match LANGUAGE.owners(word).as_slice() {
        [] => diagnostic.at(keyword.span, "").help("an element is written `TYPE NAME { ... }`"),
        owners => {
            let list = quoted_list(owners.iter().copied(), 3);
            diagnostic.at(keyword.span, format!("this is an attribute of {list}"))
        }
    }
}
