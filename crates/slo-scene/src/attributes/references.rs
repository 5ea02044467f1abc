//! References from one element to another by name.

use super::fields::quoted_list;
use crate::diagnostics::{Diagnostic, Diagnostics};
use crate::format::syntax::Word;
use crate::format::written;
use crate::names::{Names, invisible};

/// Missing names that are distinguished and explained; beyond that, each reference is reported by itself.
const MOST_DANGLING: usize = 100;

/// Kinds of elements that others refer to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Referred {
    PhongInfo,
    Material,
    Texture,
    /// An object, a light, or a group.
    Object,
}

impl Referred {
    /// All, in the order of their numbers.
    const ALL: [Self; 4] = [Self::PhongInfo, Self::Material, Self::Texture, Self::Object];

    /// What messages call an element of this kind.
    const fn name(self) -> &'static str {
        match self {
            Self::PhongInfo => "phong_info",
            Self::Material => "material",
            Self::Texture => "texture",
            Self::Object => "object",
        }
    }
}

/// A name that no element has, and everything that refers to it.
struct Dangling<'a> {
    referred: Referred,
    words: Vec<Word<'a>>,
}

/// The names of all elements that others refer to.
pub(crate) struct References<'a> {
    /// By [`Referred`].
    names: [Names<'a>; Referred::ALL.len()],
    /// Names of elements of unknown types: a reference may mean one of them.
    unknown: Names<'a>,
    /// Whether the end of the text is lost, so that elements may be missing.
    is_truncated: bool,
    dangling: Vec<Dangling<'a>>,
}

impl<'a> References<'a> {
    /// Knows only the names of elements of unknown types.
    pub(crate) fn new(unknown: &[Word<'a>], is_truncated: bool) -> Self {
        let names = Referred::ALL.map(|referred| Names::new(referred.name()));
        let mut unknown_names = Names::new("element");
        unknown.iter().for_each(|word| _ = unknown_names.declare(*word));
        Self { names, unknown: unknown_names, is_truncated, dangling: Vec::new() }
    }

    /// Adds an element; its index is the number of elements of its kind before it. Reports a name
    /// that is given twice.
    pub(crate) fn declare(
        &mut self,
        referred: Referred,
        word: Word<'a>,
        diagnostics: &mut Diagnostics,
    ) {
        let names = &mut self.names[referred as usize];
        if let Some(double) = names.declare(word) {
            let message = format!("two {}s are called `{}`", names.kind(), word.text);
            let error = Diagnostic::error(message).at(double.again, "again");
            diagnostics.push(error.also(double.first, "first here"));
        }
    }

    /// Adds an object, a light or a group, whose name may be given twice as long as nothing refers
    /// to it.
    pub(crate) fn declare_object(&mut self, word: Word<'a>) {
        _ = self.names[Referred::Object as usize].declare(word);
    }

    /// Index of the element that a word refers to; notes a missing one, and reports a name that
    /// several elements have.
    pub(crate) fn find_only(
        &mut self,
        referred: Referred,
        word: Word<'a>,
        diagnostics: &mut Diagnostics,
    ) -> Option<usize> {
        let found = self.find(referred, word);
        let names = &self.names[referred as usize];
        let Some(double) = found.and_then(|first| names.double(first)) else { return found };
        let message = format!("two {}s are called `{}`", names.kind(), written(word.text));
        let error = Diagnostic::error(message).at(word.span, "this may mean both");
        diagnostics.push(error.also(double.first, "one").also(double.again, "the other"));
        None
    }

    /// Index of the element that a word refers to; notes a missing one.
    pub(crate) fn find(&mut self, referred: Referred, word: Word<'a>) -> Option<usize> {
        let found = self.names[referred as usize].find(word.text);
        if found.is_none() && !self.unknown.contains(word.text) && !self.is_truncated {
            self.note_dangling(referred, word);
        }
        found
    }

    fn note_dangling(&mut self, referred: Referred, word: Word<'a>) {
        let same = |d: &&mut Dangling<'_>| d.referred == referred && d.words[0].text == word.text;
        match self.dangling.iter_mut().take(MOST_DANGLING).find(same) {
            Some(dangling) => dangling.words.push(word),
            None => self.dangling.push(Dangling { referred, words: vec![word] }),
        }
    }

    /// Whether any element refers to a missing one.
    pub(crate) fn are_dangling(&self) -> bool {
        !self.dangling.is_empty()
    }

    /// Reports references to missing elements.
    pub(crate) fn report_dangling(&self, diagnostics: &mut Diagnostics) {
        for (i, Dangling { referred, words }) in self.dangling.iter().enumerate() {
            let mut diagnostic = self.dangling(*referred, words[0], i < MOST_DANGLING);
            for word in words[1..].iter().take(2) {
                diagnostic = diagnostic.also(word.span, "and here");
            }
            if words.len() > 3
                && let Some(last) = diagnostic.secondary.last_mut()
            {
                last.text = format!("and here, and in {} more places", words.len() - 3);
            }
            diagnostics.push(diagnostic);
        }
    }

    /// The error about a missing element. If it `is_explained`, it says which name was probably
    /// meant.
    fn dangling(&self, referred: Referred, word: Word<'_>, is_explained: bool) -> Diagnostic {
        let names = &self.names[referred as usize];
        let kind = names.kind();
        let message = format!("no {kind} is called `{}`", word.text);
        if !is_explained {
            return Diagnostic::error(message).at(word.span, "");
        }
        let mut others = Referred::ALL.into_iter().filter(|other| *other != referred);
        let other = others.find(|other| self.names[*other as usize].contains(word.text));
        if let Some(other) = other {
            let label = format!("this is the name of a {}", other.name());
            return Diagnostic::error(message).at(word.span, label);
        }
        if referred == Referred::Texture && is_file(word.text) {
            let help = format!(
                "write `texture NAME {{ filename {} }}`, and its name here",
                written(word.text)
            );
            return Diagnostic::error(message).at(word.span, "this is a file").help(help);
        }
        if let Some(near) = names.closest(word.text) {
            let error = Diagnostic::error(format!("{message}, did you mean `{}`?", written(near)));
            return Diagnostic { help: invisible(word.text), ..error.at(word.span, "") };
        }
        let diagnostic = Diagnostic::error(message);
        let known: Vec<_> = names.all().filter(|n| !n.is_empty()).collect();
        let help = match known.as_slice() {
            [] => format!("the scene has no {kind}"),
            known => format!("there is {}", quoted_list(known.iter().map(|name| written(name)), 8)),
        };
        diagnostic.at(word.span, "").help(help)
    }

    /// Warns of elements that nothing refers to.
    pub(crate) fn warn_unused(&self, diagnostics: &mut Diagnostics) {
        // Most objects are referred to by nothing.
        let of_objects = Referred::Object as usize;
        self.names[..of_objects].iter().for_each(|names| names.warn_unused(diagnostics));
    }
}

/// Whether a word is the path of an image.
fn is_file(word: &str) -> bool {
    const EXTENSIONS: [&str; 5] = ["png", "jpg", "jpeg", "exr", "hdr"];
    let extension = word.rsplit_once('.').map_or("", |(_, extension)| extension);
    EXTENSIONS.iter().any(|known| extension.eq_ignore_ascii_case(known))
}
