//! Names of elements, and the names that were probably meant.

use std::collections::HashMap;

use crate::diagnostics::{Diagnostic, Diagnostics, SourceId, Span};
use crate::format::syntax::Word;

/// Most names that are compared with a misspelt one: this bounds the time of a scene with a hundred
/// thousand dangling references.
const MOST_CANDIDATES: usize = 2000;

/// The candidate that a misspelt word was most probably meant to be; `None` if none is near.
pub(crate) fn closest<'c>(
    word: &str,
    candidates: impl Iterator<Item = &'c str>,
) -> Option<&'c str> {
    let plain = simplified(word);
    let length = plain.chars().count();
    let allowed = if length < 3 { 0 } else { (length / 3).clamp(1, 4) };
    candidates
        .map(|candidate| (distance(&plain, &simplified(candidate), allowed), candidate))
        .filter(|(distance, _)| *distance <= allowed)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

/// Whether two words differ in capitals, underscores and punctuation only.
pub(crate) fn is_same(word: &str, other: &str) -> bool {
    simplified(word) == simplified(other)
}

/// Edits from one to the other, unless lengths alone rule them out.
fn distance(a: &str, b: &str, allowed: usize) -> usize {
    let difference = a.chars().count().abs_diff(b.chars().count());
    if difference > allowed { usize::MAX } else { strsim::osa_distance(a, b) }
}

/// Without capitals, underscores, quotes and punctuation; a word too long to be a typo is cut.
fn simplified(word: &str) -> String {
    const SKIPPED: &str = "_-,;:=\"'`´‘’‚“”„«»";
    let is_kept = |c: &char| !SKIPPED.contains(*c) && !is_invisible(*c);
    word.chars().take(100).filter(is_kept).flat_map(char::to_lowercase).collect()
}

fn is_invisible(c: char) -> bool {
    matches!(c, '\u{ad}' | '\u{200b}'..='\u{200f}' | '\u{2060}'..='\u{2064}' | '\u{feff}')
}

/// Why a word is not what it seems to be: help for the error about it.
pub(crate) fn invisible(word: &str) -> Option<String> {
    let c = word.chars().find(|c| is_invisible(*c))?;
    Some(format!("the word holds an invisible character, U+{:04X}: type it again", u32::from(c)))
}

/// The elements of one kind that can be referred to.
#[derive(Debug)]
pub(crate) struct Names<'a> {
    /// As in "no material is called ...".
    kind: &'static str,
    entries: Vec<Named<'a>>,
    by_name: HashMap<&'a str, usize>,
}

#[derive(Debug)]
struct Named<'a> {
    word: Word<'a>,
    used: bool,
}

impl<'a> Names<'a> {
    pub(crate) fn new(kind: &'static str) -> Self {
        Self { kind, entries: Vec::new(), by_name: HashMap::new() }
    }

    /// Adds the next element; its index is the number of elements before it.
    pub(crate) fn declare(&mut self, word: Word<'a>) -> Option<Redefinition> {
        let index = self.entries.len();
        self.entries.push(Named { word, used: false });
        let first = *self.by_name.entry(word.text).or_insert(index);
        let is_double = first != index && !word.text.is_empty();
        is_double.then(|| Redefinition { first: self.entries[first].word.span, again: word.span })
    }

    pub(crate) fn contains(&self, name: &str) -> bool {
        self.by_name.contains_key(name)
    }

    /// Index of the element of a name; marks it as used.
    pub(crate) fn find(&mut self, name: &str) -> Option<usize> {
        let index = *self.by_name.get(name)?;
        self.entries[index].used = true;
        Some(index)
    }

    /// The most similar name, of the first thousands.
    pub(crate) fn closest(&self, name: &str) -> Option<&'a str> {
        closest(name, self.entries.iter().take(MOST_CANDIDATES).map(|e| e.word.text))
    }

    /// All names, for a help that lists them.
    pub(crate) fn all(&self) -> impl Iterator<Item = &'a str> {
        self.entries.iter().map(|e| e.word.text)
    }

    /// Warns of what nothing refers to. What a file that is included offers need not be used.
    pub(crate) fn warn_unused(&self, diagnostics: &mut Diagnostics) {
        let is_own = |named: &&Named<'_>| named.word.span.source == SourceId(0);
        for named in self.entries.iter().filter(|e| !e.used).filter(is_own) {
            let message = format!("unused {} `{}`", self.kind, named.word.text);
            diagnostics
                .push(Diagnostic::warning(message).at(named.word.span, "nothing refers to this"));
        }
    }

    pub(crate) fn kind(&self) -> &'static str {
        self.kind
    }
}

/// Two elements of one kind with the same name.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Redefinition {
    pub(crate) first: Span,
    pub(crate) again: Span,
}

#[cfg(test)]
mod tests {
    use super::closest;

    #[test]
    fn the_nearest_name_is_suggested() {
        let names = ["ambient", "diffuse", "diffuse_reflection", "specular", "Camera"];
        let cases = [
            ("difuse", Some("diffuse")),
            ("camera", Some("Camera")),
            ("diffuseReflection", Some("diffuse_reflection")),
            ("speuclar", Some("specular")),
            ("“diffuse”", Some("diffuse")),
            ("specular,", Some("specular")),
            ("amb\u{200b}ient", Some("ambient")),
            ("radius", None),
            ("p", None),
            ("CAMERA_", Some("Camera")),
            ("", None),
        ];
        for (word, expected) in cases {
            assert_eq!(closest(word, names.into_iter()), expected, "{word}");
        }
    }
}
