//! The attributes of one element, checked against what the element takes.

use std::fmt::Display;

use super::elsewhere::attribute_meant;
use super::language::Language;
use super::schema::{Attribute, Kind, Schema};
use crate::diagnostics::{Diagnostic, Diagnostics, Span};
use crate::format::syntax::{Block, Entry, Form, Item, Number, Word};
use crate::names::{closest, invisible};

/// An element, or a block of an element, as it was written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Element<'t, 'a> {
    pub(crate) schema: &'static Schema,
    pub(crate) keyword: Word<'a>,
    /// Empty if the block has or needs no name.
    pub(crate) name: Word<'a>,
    pub(crate) block: &'t Block<'a>,
    /// Whether braces are wrong in the block or around it: attributes of this element may stand
    /// elsewhere, and foreign ones here.
    pub(crate) damaged: bool,
}

impl Element<'_, '_> {
    /// As messages call it: "sphere `ball`".
    pub(crate) fn title(&self) -> String {
        match self.name.text {
            "" => format!("`{}`", self.keyword.text),
            name => format!("{} `{name}`", self.keyword.text),
        }
    }

    /// Keyword and name.
    pub(crate) fn head(&self) -> Span {
        if self.name.text.is_empty() {
            self.keyword.span
        } else {
            self.keyword.span.to(self.name.span)
        }
    }
}

/// The value of an attribute, in the form that the attribute takes.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Value<'t, 'a> {
    Word(Word<'a>),
    Block(&'t Block<'a>),
    Element(Word<'a>, &'t Block<'a>),
    /// Something else, which was reported.
    Broken,
}

/// An attribute that was written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Field<'t, 'a> {
    pub(crate) attribute: &'static Attribute,
    pub(crate) keyword: Word<'a>,
    pub(crate) value: Value<'t, 'a>,
}

/// The attributes of one element.
pub(crate) struct Fields<'t, 'a, 'd> {
    pub(crate) element: Element<'t, 'a>,
    pub(crate) diagnostics: &'d mut Diagnostics,
    /// `Scaling`.
    pub(crate) scale: f64,
    language: &'static Language,
    found: Vec<Field<'t, 'a>>,
    /// Number of attributes that this element does not take and that resemble none of its own.
    strangers: usize,
}

impl<'t, 'a, 'd> Fields<'t, 'a, 'd> {
    /// Reads the block of an element; reports attributes that do not belong there, are given twice,
    /// have the wrong form, or are missing.
    pub(crate) fn read(
        element: Element<'t, 'a>,
        language: &'static Language,
        scale: f64,
        diagnostics: &'d mut Diagnostics,
    ) -> Self {
        let mut fields = Self { scale, ..Self::bare(element, language, diagnostics) };
        let mut entries = element.block.entries.iter().peekable();
        while let Some(entry) = entries.next() {
            let mut numbers = Vec::new();
            while let Some(Entry::Number(number)) = entries.peek() {
                numbers.push(number);
                entries.next();
            }
            fields.entry(entry, &numbers);
        }
        fields.report_missing();
        fields
    }

    /// An element without attributes: nothing is read yet.
    pub(crate) fn bare(
        element: Element<'t, 'a>,
        language: &'static Language,
        diagnostics: &'d mut Diagnostics,
    ) -> Self {
        Self { element, diagnostics, scale: 1.0, language, found: Vec::new(), strangers: 0 }
    }

    /// The attributes of a block or element in this one; `None` if it is broken, which was reported.
    pub(crate) fn open(&mut self, field: Field<'t, 'a>) -> Option<Fields<'t, 'a, '_>> {
        let nameless = Word { text: "", span: field.keyword.span };
        let (schema, name, block) = match (field.attribute.kind, field.value) {
            (Kind::Block(schema) | Kind::WordOrBlock(_, schema), Value::Block(block)) => {
                (schema, nameless, block)
            }
            (Kind::Element(schema), Value::Element(name, block)) => (schema, name, block),
            _ => return None,
        };
        let damaged = self.element.damaged || block.damaged;
        let element = Element { schema, keyword: field.keyword, name, block, damaged };
        Some(Fields::read(element, self.language, self.scale, self.diagnostics))
    }

    /// The first attribute of that name.
    pub(crate) fn get(&self, name: &str) -> Option<Field<'t, 'a>> {
        self.found.iter().find(|f| f.attribute.name == name).copied()
    }

    /// Which one of two attributes stands there. Reports both, and neither.
    pub(crate) fn either(&mut self, names: [&'static str; 2]) -> Option<&'static str> {
        let [first, second] = names.map(|name| self.get(name));
        match (first, second) {
            (Some(_), None) => Some(names[0]),
            (None, Some(_)) => Some(names[1]),
            (Some(first), Some(second)) => {
                let [one, other] = names;
                let message = format!("{} has `{one}` and `{other}`", self.element.title());
                let (a, b) = (first.keyword.span, second.keyword.span);
                let error = Diagnostic::error(message).at(a.max(b), "one of the two is too much");
                self.diagnostics.push(error.also(a.min(b), ""));
                None
            }
            (None, None) => {
                // An unknown attribute is probably the missing one, misspelt.
                if !self.element.damaged && self.strangers == 0 {
                    self.report_neither(names);
                }
                None
            }
        }
    }

    fn report_neither(&mut self, [one, other]: [&'static str; 2]) {
        let message = format!("{} has neither `{one}` nor `{other}`", self.element.title());
        let usage = |name| self.element.schema.attribute(name).map(Attribute::usage);
        let usages: Vec<_> = [one, other].into_iter().filter_map(usage).collect();
        let label = format!("expected {} in this", usages.join(" or "));
        let error = Diagnostic::error(message).at(self.element.head(), label);
        self.diagnostics.push(error);
    }

    /// All attributes of that name.
    pub(crate) fn all(&self, name: &str) -> Vec<Field<'t, 'a>> {
        self.found.iter().filter(|f| f.attribute.name == name).copied().collect()
    }

    /// The words behind all attributes of that name; `None` if one of them is broken.
    pub(crate) fn words(&self, name: &str) -> Option<Vec<Word<'a>>> {
        let words = self.all(name).into_iter().map(|field| match field.value {
            Value::Word(word) => Some(word),
            _ => None,
        });
        words.collect()
    }

    /// Reads an entry and the numbers that follow it, which are surplus or lack their braces.
    fn entry(&mut self, entry: &'t Entry<'a>, numbers: &[&Number<'a>]) {
        match entry {
            Entry::Number(first) => self.stray_numbers(first, numbers),
            Entry::Item(item) => {
                let is_whole = self.item(item, numbers);
                if let (true, [first, rest @ ..]) = (is_whole, numbers) {
                    self.stray_numbers(first, rest);
                }
            }
        }
    }

    fn stray_numbers(&mut self, first: &Number<'_>, rest: &[&Number<'_>]) {
        if first.value.is_none() {
            return;
        }
        let span = first.word.span.to(rest.last().map_or(first.word.span, |n| n.word.span));
        let found = if rest.is_empty() { "a number" } else { "numbers" };
        let mut diagnostic =
            Diagnostic::error(format!("expected an attribute, found {found}")).at(span, "");
        diagnostic.help = Some(self.takes());
        self.diagnostics.push(diagnostic);
    }

    /// Reads an attribute. Returns whether it is correct; if not, this was reported.
    fn item(&mut self, item: &'t Item<'a>, numbers: &[&Number<'a>]) -> bool {
        let keyword = item.keyword;
        let Some(attribute) = self.element.schema.attribute(keyword.text) else {
            self.unknown(item);
            return false;
        };
        let value = self.value(attribute, item, numbers);
        let first = self.get(attribute.name);
        if let (Some(first), false) = (first, attribute.repeated) {
            self.twice(keyword, first.keyword);
        } else {
            self.found.push(Field { attribute, keyword, value });
        }
        !matches!(value, Value::Broken)
    }

    fn twice(&mut self, again: Word<'_>, first: Word<'_>) {
        let message = format!("`{}` is given twice in {}", again.text, self.element.title());
        self.diagnostics.push(
            Diagnostic::error(message).at(again.span, "again").also(first.span, "first here"),
        );
    }

    fn unknown(&mut self, item: &Item<'a>) {
        let (word, schema) = (item.keyword, self.element.schema);
        let called = schema.called(word.text).or_else(|| attribute_meant(word.text, schema));
        let near = || closest(word.text, schema.attributes().map(|a| a.name));
        let attribute = called.or_else(|| near().and_then(|name| schema.attribute(name)));
        let diagnostic = if let Some(help) = schema.absent(word.text) {
            let message = format!("`{}` does not take `{}` yet", schema.keyword, word.text);
            Diagnostic::error(message).at(word.span, "").help(help)
        } else if let Some(attribute) = attribute {
            let usage = || called.map(|attribute| format!("write {}", attribute.usage()));
            let help = invisible(word.text).or_else(usage);
            // A misspelt attribute is not missing.
            self.found.push(Field { attribute, keyword: word, value: Value::Broken });
            let error = Diagnostic::error(format!(
                "unknown attribute `{}` in `{}`, did you mean `{}`?",
                word.text, schema.keyword, attribute.name
            ));
            Diagnostic { help, ..error.at(word.span, "") }
        } else {
            if self.element.damaged && !self.language.owners(word.text).is_empty() {
                return;
            }
            self.strangers += 1;
            self.misplaced(word, &item.form)
        };
        self.diagnostics.push(diagnostic);
    }

    fn misplaced(&self, word: Word<'_>, form: &Form<'_>) -> Diagnostic {
        let keyword = self.element.schema.keyword;
        if matches!(form, Form::Element(..)) && self.language.has_element(word.text) {
            return Diagnostic::error(format!("`{}` can't stand in `{keyword}`", word.text))
                .at(word.span, "this is an element of the scene")
                .help(format!("write it outside of {}", self.element.title()));
        }
        let owners = self.language.owners(word.text);
        let label = match owners.as_slice() {
            [] => String::new(),
            owners => format!("this is an attribute of {}", quoted_list(owners.iter().copied(), 3)),
        };
        Diagnostic::error(format!("unknown attribute `{}` in `{keyword}`", word.text))
            .at(word.span, label)
            .help(self.takes())
    }

    /// What may stand in this element, as help.
    fn takes(&self) -> String {
        let names = self.element.schema.attributes().map(|a| a.name);
        format!("`{}` takes {}", self.element.schema.keyword, quoted_list(names, usize::MAX))
    }

    /// The value of an attribute in the form that it takes.
    fn value(
        &mut self,
        attribute: &Attribute,
        item: &'t Item<'a>,
        numbers: &[&Number<'a>],
    ) -> Value<'t, 'a> {
        match (attribute.kind, &item.form) {
            (_, Form::Value(sign @ Word { text: "=" | ":", .. })) => {
                self.sign(attribute, *sign);
                Value::Broken
            }
            (_, Form::Broken) => Value::Broken,
            (_, Form::Nothing) => {
                let message = format!("`{}` has no value", item.keyword.text);
                let error = Diagnostic::error(message).at(item.keyword.span, "");
                self.diagnostics.push(error.help(format!("write {}", attribute.usage())));
                Value::Broken
            }
            (
                Kind::Number | Kind::Choice | Kind::Word(_) | Kind::WordOrBlock(..),
                Form::Value(word),
            ) => Value::Word(*word),
            (Kind::Vector(_) | Kind::Single(_) | Kind::Block(_), Form::Block(block)) => {
                Value::Block(block)
            }
            (Kind::WordOrBlock(..), Form::Block(block)) if !holds_numbers(block) => {
                Value::Block(block)
            }
            (Kind::Element(_), Form::Element(name, block)) => Value::Element(*name, block),
            (Kind::Element(_), Form::Block(block)) => {
                self.diagnostics.push(nameless(item.keyword));
                Value::Element(Word { text: "", span: item.keyword.span }, block)
            }
            (Kind::Vector(_) | Kind::Single(_) | Kind::Block(_), Form::Element(name, block)) => {
                let message = format!("`{}` takes no name", item.keyword.text);
                self.diagnostics.push(
                    Diagnostic::error(message)
                        .at(name.span, "expected `{`, found this")
                        .help(format!("write {}", attribute.usage())),
                );
                Value::Block(block)
            }
            (_, form) => {
                self.wrong_form(attribute, item.keyword, form, numbers);
                Value::Broken
            }
        }
    }

    fn sign(&mut self, attribute: &Attribute, sign: Word<'_>) {
        let (name, sign, span) = (attribute.name, sign.text, sign.span);
        let message = format!("`{name}` is followed by its value, without `{sign}`");
        let error = Diagnostic::error(message).at(span, "");
        self.diagnostics.push(error.help(format!("write {}", attribute.usage())));
    }

    fn wrong_form(
        &mut self,
        attribute: &Attribute,
        keyword: Word<'a>,
        form: &Form<'a>,
        numbers: &[&Number<'a>],
    ) {
        let (span, found) = match form {
            Form::Value(word) => (word.span, "found this"),
            Form::Block(block) => (block.open, "found `{`"),
            Form::Element(name, _) => (name.span, "found this"),
            Form::Nothing | Form::Broken => (keyword.span, "found nothing"),
        };
        let expected = match attribute.kind {
            Kind::Number => "a number without braces",
            Kind::Choice => "one word",
            Kind::Word(_) => "one word without braces",
            Kind::Vector(_) => "three numbers in braces",
            Kind::Single(_) => "one number in braces",
            Kind::Block(_) => "a block in braces",
            Kind::Element(_) => "a name and a block in braces",
            Kind::WordOrBlock(..) if matches!(form, Form::Element(..)) => {
                "a name or a block, not both"
            }
            Kind::WordOrBlock(..) => "a name, or a block of attributes",
            Kind::Absent(_) => "nothing",
        };
        let help = rewritten(attribute.kind, keyword, form, numbers)
            .unwrap_or_else(|| format!("write {}", attribute.usage()));
        self.diagnostics.push(
            Diagnostic::error(format!("`{}` takes {expected}", keyword.text))
                .at(span, found)
                .help(help),
        );
    }

    fn report_missing(&mut self) {
        if self.element.damaged {
            return;
        }
        let attributes = self.element.schema.attributes();
        let missing: Vec<_> =
            attributes.filter(|a| a.required && self.get(a.name).is_none()).collect();
        // The unknown attributes are probably the missing ones, misspelt.
        if missing.len() <= self.strangers {
            return;
        }
        let names: Vec<_> = missing.iter().map(|a| format!("`{}`", a.name)).collect();
        let usages: Vec<_> = missing.iter().map(|a| a.usage()).collect();
        self.diagnostics.push(
            Diagnostic::error(format!(
                "{} has no {}",
                self.element.title(),
                names.join(" and no ")
            ))
            .at(self.element.head(), format!("expected {} in this", usages.join(", "))),
        );
    }
}

/// Whether a block begins with a number, as vectors do.
fn holds_numbers(block: &Block<'_>) -> bool {
    matches!(block.entries.first(), Some(Entry::Number(_)))
}

/// The error about an element without a name.
pub(crate) fn nameless(keyword: Word<'_>) -> Diagnostic {
    Diagnostic::error(format!("this `{}` has no name", keyword.text))
        .at(keyword.span, "expected a name after this")
        .help(format!("write `{} NAME {{ ... }}`", keyword.text))
}

/// What a value in the wrong form was probably meant to be.
fn rewritten(
    kind: Kind,
    keyword: Word<'_>,
    form: &Form<'_>,
    numbers: &[&Number<'_>],
) -> Option<String> {
    let keyword = keyword.text;
    match (kind, form, numbers) {
        (Kind::Vector(_), Form::Value(x), [y, z]) => {
            Some(format!("write `{keyword} {{ {} {} {} }}`", x.text, y.word.text, z.word.text))
        }
        (Kind::Single(_), Form::Value(x), []) => {
            Some(format!("write `{keyword} {{ {} }}`", x.text))
        }
        (Kind::WordOrBlock(_, schema), Form::Element(name, _), _) => {
            let first = schema.attributes().next()?.name;
            Some(format!("write `{keyword} {{ {first} {} ... }}`", name.text))
        }
        (_, Form::Block(block), _) => match block.entries.as_slice() {
            [Entry::Number(Number { word, .. })]
            | [Entry::Item(Item { keyword: word, form: Form::Nothing })] => {
                Some(format!("write `{keyword} {}`", word.text))
            }
            _ => None,
        },
        _ => None,
    }
}

/// "`a`, `b` and 3 others"
pub(crate) fn quoted_list<S: Display>(names: impl Iterator<Item = S>, most: usize) -> String {
    let names: Vec<_> = names.map(|n| format!("`{n}`")).collect();
    match names.len() {
        n if n > most => {
            let others = match n - most {
                1 => "one other".to_owned(),
                others => format!("{others} others"),
            };
            format!("{} and {others}", names[..most].join(", "))
        }
        _ => names.join(", "),
    }
}
