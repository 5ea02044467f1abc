//! Values of attributes, checked: numbers in their ranges, points, colours, words of a list.

use glam::DVec3;

use super::fields::{Field, Fields, Value, quoted_list};
use crate::diagnostics::{Diagnostic, Span};
use crate::format::syntax::{Block, Entry, Word};
use crate::format::{looks_like_number, parse_number};
use crate::names::closest;
use crate::settings::{Bound, Choice};

/// Positions and lengths past this would overflow the f32 arithmetic of the triangle test, which
/// multiplies four of them.
pub(crate) const FARTHEST: f64 = 1e9;

/// The shortest length that is not 0: its fourth power is still a normal f32.
pub(crate) const SHORTEST: f64 = 1e-9;

/// The label of directions that are too short or too long: their squares would leave f64.
const LENGTHS: &str = "expected a length from 1e-150 to 1e150";

/// If the brightest channel of a colour of whole numbers is more than this, its channels were
/// probably meant to go up to 255.
const DIMMEST_BYTE: f64 = 32.0;

/// A value with its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Found<T> {
    pub(crate) value: T,
    pub(crate) span: Span,
}

impl<'t, 'a> Fields<'t, 'a, '_> {
    /// The word behind an attribute.
    pub(crate) fn word(&self, name: &str) -> Option<Word<'a>> {
        match self.get(name)?.value {
            Value::Word(word) => Some(word),
            _ => None,
        }
    }

    /// A number within a bound.
    pub(crate) fn number(&mut self, name: &str, bound: Bound) -> Option<Found<f64>> {
        let word = self.word(name)?;
        let value = self.parse(word)?;
        if let Some(rule) = bound.broken_by(value) {
            self.out_of_range(name, word, rule);
            return None;
        }
        Some(Found { value, span: word.span })
    }

    /// A number within a bound that is kept in f32.
    pub(crate) fn number_f32(&mut self, name: &str, bound: Bound) -> Option<f32> {
        let found = self.number(name, bound)?;
        let value = self.fit_f32(found)?;
        if matches!(bound, Bound::Positive | Bound::Error) && value == 0.0 {
            let word = self.word(name)?;
            self.out_of_range(name, word, "is too close to 0");
            return None;
        }
        Some(value)
    }

    /// A number within a bound and not above `most`, kept in f32.
    pub(crate) fn number_to(&mut self, name: &str, bound: Bound, most: f32) -> Option<f32> {
        let value = self.number_f32(name, bound)?;
        if value > most {
            let word = self.word(name)?;
            self.out_of_range(name, word, &format!("must be {most} or less"));
            return None;
        }
        Some(value)
    }

    fn fit_f32(&mut self, found: Found<f64>) -> Option<f32> {
        let value = found.value as f32;
        if !value.is_finite() {
            let message = format!("the number is larger than {:e}", f32::MAX);
            self.diagnostics.push(Diagnostic::error(message).at(found.span, ""));
            return None;
        }
        Some(value)
    }

    /// A length, scaled.
    pub(crate) fn length(&mut self, name: &str, bound: Bound) -> Option<Found<f64>> {
        let found = self.number(name, bound)?;
        let value = found.value * self.scale;
        self.check_distance(value, found.span)?;
        if bound == Bound::Positive && value < SHORTEST {
            let word = self.word(name)?;
            self.out_of_range(name, word, &format!("is less than {SHORTEST:e}"));
            return None;
        }
        Some(Found { value, ..found })
    }

    /// A length in braces, scaled.
    pub(crate) fn length_in_braces(&mut self, name: &str) -> Option<Found<f64>> {
        let field = self.get(name)?;
        let Value::Block(block) = field.value else { return None };
        let [value] = self.numbers(field.keyword, block)?;
        let (value, span) = (value * self.scale, block.open.to(block.close));
        if value < SHORTEST {
            let what = if value > 0.0 { "is less than 1e-9" } else { "must be more than 0" };
            self.diagnostics.push(Diagnostic::error(format!("`{name}` {what}")).at(span, ""));
            return None;
        }
        self.check_distance(value, span)?;
        Some(Found { value, span })
    }

    /// A whole number in a range.
    pub(crate) fn count(&mut self, name: &str, least: u32, most: u32) -> Option<Found<u32>> {
        let word = self.word(name)?;
        let value = self.parse(word)?;
        if value.fract() != 0.0 {
            self.out_of_range(name, word, "must be a whole number");
        } else if value < f64::from(least) {
            self.out_of_range(name, word, &format!("must be {least} or more"));
        } else if value > f64::from(most) {
            self.out_of_range(name, word, &format!("must be {most} or less"));
        } else {
            return Some(Found { value: value as u32, span: word.span });
        }
        None
    }

    /// A whole number of 64 bits.
    pub(crate) fn seed(&mut self, name: &str) -> Option<u64> {
        let word = self.word(name)?;
        if let Ok(seed) = word.text.parse() {
            return Some(seed);
        }
        let value = self.parse(word)?;
        if value.fract() != 0.0 || value < 0.0 || value >= 2.0 * (1_u64 << 63) as f64 {
            self.out_of_range(name, word, "must be a whole number from 0 to 18446744073709551615");
            return None;
        }
        Some(value as u64)
    }

    /// One of several words.
    pub(crate) fn choice(&mut self, name: &str, words: &[&'static str]) -> Option<&'static str> {
        let word = self.word(name)?;
        if let Some(found) = words.iter().find(|known| **known == word.text) {
            return Some(found);
        }
        let words = words.iter().copied();
        let mut diagnostic = Diagnostic::error(match closest(word.text, words.clone()) {
            Some(near) => format!("unknown {name} `{}`, did you mean `{near}`?", word.text),
            None => format!("unknown {name} `{}`", word.text),
        });
        diagnostic.help = Some(format!("`{name}` is one of {}", quoted_list(words, usize::MAX)));
        self.diagnostics.push(diagnostic.at(word.span, ""));
        None
    }

    /// The value of an attribute that takes one of several words.
    pub(crate) fn one_of<C: Choice>(&mut self, name: &str) -> Option<C> {
        C::by_name(self.choice(name, C::WORDS)?)
    }

    /// Three numbers as they are.
    pub(crate) fn vector(&mut self, name: &str) -> Option<Found<DVec3>> {
        self.get(name).and_then(|field| self.vector_of(field))
    }

    /// Three numbers that are not all 0, of a length that can be squared.
    pub(crate) fn direction(&mut self, name: &str) -> Option<Found<DVec3>> {
        let found = self.vector(name)?;
        if found.value.try_normalize().is_none() {
            let largest = found.value.abs().max_element();
            let (what, label) = match largest {
                0.0 => ("has no direction", "expected a vector that is not zero"),
                ..1.0 => ("is too short", LENGTHS),
                _ => ("is too long", LENGTHS),
            };
            let message = format!("`{name}` {what}");
            self.diagnostics.push(Diagnostic::error(message).at(found.span, label));
            return None;
        }
        Some(found)
    }

    /// A position, scaled.
    pub(crate) fn point(&mut self, name: &str) -> Option<Found<DVec3>> {
        self.get(name).and_then(|field| self.point_of(field))
    }

    /// Positions of an attribute that may be repeated, scaled.
    pub(crate) fn points(&mut self, name: &str) -> Vec<Found<DVec3>> {
        self.all(name).into_iter().filter_map(|field| self.point_of(field)).collect()
    }

    /// Red, green and blue of a colour, none below 0. A colour from 0 to 255 gets a warning.
    pub(crate) fn color(&mut self, name: &str) -> Option<[f32; 3]> {
        let Found { value, span } = self.light(name)?;
        check_color(self, name, span, value);
        Some(value)
    }

    /// Red, green and blue of light, however strong; none below 0.
    pub(crate) fn light(&mut self, name: &str) -> Option<Found<[f32; 3]>> {
        let found = self.vector(name)?;
        if found.value.min_element() < 0.0 {
            let message = format!("`{name}` must not be negative");
            self.diagnostics.push(Diagnostic::error(message).at(found.span, ""));
            return None;
        }
        let [r, g, b] =
            found.value.to_array().map(|value| self.fit_f32(Found { value, span: found.span }));
        Some(Found { value: [r?, g?, b?], span: found.span })
    }

    fn point_of(&mut self, field: Field<'t, 'a>) -> Option<Found<DVec3>> {
        let found = self.vector_of(field)?;
        let value = found.value * self.scale;
        self.check_distance(value.abs().max_element(), found.span)?;
        Some(Found { value, ..found })
    }

    fn vector_of(&mut self, field: Field<'t, 'a>) -> Option<Found<DVec3>> {
        let Value::Block(block) = field.value else { return None };
        let [x, y, z] = self.numbers(field.keyword, block)?;
        Some(Found { value: DVec3::new(x, y, z), span: block.open.to(block.close) })
    }

    /// Exactly `N` numbers in braces.
    pub(crate) fn numbers<const N: usize>(
        &mut self,
        keyword: Word<'_>,
        block: &Block<'_>,
    ) -> Option<[f64; N]> {
        if block.damaged {
            return None;
        }
        let mut numbers = Vec::new();
        for entry in &block.entries {
            match entry {
                Entry::Number(number) => numbers.push(number.value),
                Entry::Item(item) => {
                    let owner = format!("`{}` takes {}", keyword.text, numbers_in_words(N));
                    self.diagnostics.push(
                        not_a_number(item.keyword.text)
                            .at(item.keyword.span, "not a number")
                            .also(keyword.span, owner),
                    );
                    return None;
                }
            }
        }
        let Ok(numbers) = <[Option<f64>; N]>::try_from(numbers.as_slice()) else {
            // A word that is not a number may have been meant as several.
            if numbers.contains(&None) {
                return None;
            }
            let message = format!("`{}` takes {}", keyword.text, numbers_in_words(N));
            let label = format!("found {}", numbers.len());
            self.diagnostics.push(Diagnostic::error(message).at(block.open.to(block.close), label));
            return None;
        };
        numbers.into_iter().collect::<Option<Vec<_>>>()?.try_into().ok()
    }

    fn parse(&mut self, word: Word<'_>) -> Option<f64> {
        let diagnostic = match parse_number(word.text) {
            Ok(value) => return Some(value),
            Err(e) if looks_like_number(word.text) => {
                Diagnostic { help: e.help, ..Diagnostic::error(e.message) }
            }
            Err(_) => not_a_number(word.text),
        };
        self.diagnostics.push(diagnostic.at(word.span, ""));
        None
    }

    fn out_of_range(&mut self, name: &str, word: Word<'_>, rule: &str) {
        self.diagnostics.push(Diagnostic::error(format!("`{name}` {rule}")).at(word.span, ""));
    }

    fn check_distance(&mut self, value: f64, span: Span) -> Option<()> {
        if value.abs() <= FARTHEST {
            return Some(());
        }
        let scaled = if self.scale == 1.0 { "" } else { ", times `Scaling`," };
        let message = format!("a position or length{scaled} is more than {FARTHEST:e}");
        self.diagnostics.push(
            Diagnostic::error(message).at(span, "too large for the arithmetic of the renderer"),
        );
        None
    }
}

/// The error about a word instead of a number.
fn not_a_number(word: &str) -> Diagnostic {
    let error = Diagnostic::error(format!("expected a number, found `{word}`"));
    match word.strip_prefix('"').and_then(|rest| rest.strip_suffix('"')) {
        Some(number) if parse_number(number).is_ok() => {
            error.help(format!("a number has no quotes, write `{number}`"))
        }
        _ => error,
    }
}

fn numbers_in_words(n: usize) -> &'static str {
    if n == 1 { "one number in braces" } else { "three numbers in braces" }
}

/// Warns of a colour whose channels seem to go from 0 to 255.
fn check_color(fields: &mut Fields<'_, '_, '_>, name: &str, span: Span, color: [f32; 3]) {
    if looks_like_bytes(color) {
        let message = format!("`{name}` seems to be given from 0 to 255");
        let [r, g, b] = color.map(|c| format!("{:.3}", f64::from(c) / 255.0));
        let help = format!("full intensity is 1: write `{name} {{ {r} {g} {b} }}`");
        fields.diagnostics.push(Diagnostic::warning(message).at(span, "").help(help));
    }
}

/// Whether the channels of a colour seem to go from 0 to 255.
pub(crate) fn looks_like_bytes(color: [f32; 3]) -> bool {
    let color = color.map(f64::from);
    let largest = color.into_iter().fold(0.0, f64::max);
    (DIMMEST_BYTE..=255.0).contains(&largest) && color.iter().all(|c| c.fract() == 0.0)
}
