//! The elements at the top of a scene, by type.

use super::elements::{ELEMENTS, LANGUAGE, Role};
use crate::attributes::{Element, References, Referred, element_meant, nameless, quoted_list};
use crate::diagnostics::{Diagnostic, Diagnostics};
use crate::format::syntax::{Entry, Form, Item, Tree, Word};
use crate::names::{Names, closest, invisible};

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
    pub(super) fn collect(tree: &'t Tree<'a>, diagnostics: &mut Diagnostics) -> Self {
        let is_truncated = tree.truncated;
        let mut scene = Self { elements: Vec::new(), unknown: Vec::new(), is_truncated };
        let mut in_numbers = false;
        // Of several unknown words in a row only the first is reported.
        let mut in_strangers = false;
        for entry in &tree.entries {
            match entry {
                Entry::Item(item) => {
                    in_numbers = !scene.item(item, in_strangers, diagnostics);
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
        scene
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

    /// All elements of a role that may hang in others, by what `of` makes of it, each with its number
    /// among those that may hang.
    pub(super) fn hanging<T>(
        &self,
        of: impl Fn(Role) -> Option<T>,
    ) -> Vec<(usize, T, Element<'t, 'a>)> {
        let hanging = self.elements.iter().filter(|(role, _)| role.hangs()).enumerate();
        hanging.filter_map(|(i, (role, element))| Some((i, of(*role)?, *element))).collect()
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
        let [mut lights, mut objects, mut groups] = ["light", "object", "group"].map(Names::new);
        let mut copies = Names::new("copy");
        for (role, element) in &self.elements {
            match role.referred() {
                Some(Referred::Object) => references.declare_object(element.name),
                Some(referred) => references.declare(referred, element.name, diagnostics),
                None => {}
            }
            match role {
                Role::Light(_) => warn_of_double(&mut lights, element.name, diagnostics),
                Role::Object(_) => warn_of_double(&mut objects, element.name, diagnostics),
                Role::Group => warn_of_double(&mut groups, element.name, diagnostics),
                Role::Copy => warn_of_double(&mut copies, element.name, diagnostics),
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

/// A name that only people read may be given twice.
fn warn_of_double<'a>(names: &mut Names<'a>, name: Word<'a>, diagnostics: &mut Diagnostics) {
    if let Some(double) = names.declare(name) {
        let plural =
            if names.kind() == "copy" { "copies".into() } else { format!("{}s", names.kind()) };
        let message = format!("two {plural} are called `{}`", name.text);
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
    let diagnostic = Diagnostic::error(format!("expected an element, found `{word}`"));
    match LANGUAGE.owners(word).as_slice() {
        [] => diagnostic.at(keyword.span, "").help("an element is written `TYPE NAME { ... }`"),
        owners => {
            let list = quoted_list(owners.iter().copied(), 3);
            diagnostic.at(keyword.span, format!("this is an attribute of {list}"))
        }
    }
}
