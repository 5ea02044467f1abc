//! Numbers, and what a word that is not a number was meant to be.

use std::fmt::{self, Display, Formatter};

/// Why a word is no number, in words for the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NumberError {
    /// What is wrong.
    pub message: String,
    /// What to write instead.
    pub help: Option<String>,
}

/// Whether a word is meant as a number: no keyword starts like this.
pub fn looks_like_number(word: &str) -> bool {
    let unsigned = word.trim_start_matches(['+', '-']).trim_start_matches(DASHES);
    match unsigned.chars().next() {
        Some(c) => c.is_ascii_digit() || (c == '.' || c == ',') || is_special(unsigned),
        None => true,
    }
}

/// The value of a word such as `1`, `-.5`, `08`, `1.`, `2e-3`; finite.
///
/// # Errors
/// The word is no number, or one too large for f64.
pub fn parse_number(word: &str) -> Result<f64, NumberError> {
    let digits_only =
        word.bytes().all(|b| matches!(b, b'0'..=b'9' | b'+' | b'-' | b'.' | b'e' | b'E'));
    match word.parse::<f64>() {
        Ok(value) if digits_only && value.is_finite() => Ok(value),
        Ok(_) if digits_only => Err(error(format!("the number `{word}` is too large"), None)),
        _ => Err(explain(word)),
    }
}

/// What word processors write for `-`: a minus sign and dashes.
const DASHES: [char; 3] = ['\u{2212}', '\u{2013}', '\u{2014}'];

fn error(message: String, help: Option<String>) -> NumberError {
    NumberError { message, help }
}

fn is_special(word: &str) -> bool {
    ["nan", "inf", "infinity"].iter().any(|s| word.eq_ignore_ascii_case(s))
}

fn explain(word: &str) -> NumberError {
    let message = format!("`{word}` is not a number");
    if is_special(word.trim_start_matches(['+', '-'])) {
        return error(format!("`{word}` is not a finite number"), None);
    }
    if word.contains(',') {
        return explain_comma(word);
    }
    let (number, rest) = split_number(word);
    let help = if !number.is_empty() && rest == ";" {
        Some(format!("write `{number}`, without the semicolon"))
    } else if word.contains(DASHES) {
        Some(format!("write `{}` with a plain minus", word.replace(DASHES, "-")))
    } else if !number.is_empty() && (rest.starts_with('#') || rest.starts_with("/*")) {
        Some(format!("put white space in front of the comment: `{number} {rest}`"))
    } else if let (Ok(percent), "%") = (number.parse::<f64>(), rest) {
        let fraction = format!("{:.9}", percent / 100.0);
        let fraction = fraction.trim_end_matches('0').trim_end_matches('.');
        Some(format!("a share is a number from 0 to 1, write `{fraction}`"))
    } else if !number.is_empty() && rest.chars().all(char::is_alphabetic) {
        Some(format!("a number has no unit, write `{number}`"))
    } else {
        None
    };
    error(message, help)
}

fn explain_comma(word: &str) -> NumberError {
    let parts: Vec<_> = word.split(',').collect();
    match parts.as_slice() {
        [number, ""] | ["", number] if parse_number(number).is_ok() => error(
            format!("`{word}` is not a number: numbers are separated by white space"),
            Some(format!("write `{number}`, without the comma")),
        ),
        [whole, fraction] if parse_number(&format!("{whole}.{fraction}")).is_ok() => error(
            format!("`{word}` is not a number: the decimal sign is a point"),
            Some(format!("write `{whole}.{fraction}`")),
        ),
        _ => error(
            format!("`{word}` is not a number: numbers are separated by white space"),
            Some(format!("write `{}`", word.replace(',', " ").trim())),
        ),
    }
}

/// The longest start of the word that is a number, and the rest.
fn split_number(word: &str) -> (&str, &str) {
    let ascii = word.bytes().take_while(u8::is_ascii).count().min(64);
    let ends = (1..=ascii).rev();
    let end = ends.into_iter().find(|end| {
        let start = &word[..*end];
        start.ends_with(|c: char| c.is_ascii_digit() || c == '.') && parse_number_quietly(start)
    });
    word.split_at(end.unwrap_or(0))
}

fn parse_number_quietly(word: &str) -> bool {
    word.bytes().all(|b| b.is_ascii_digit() || b"+-.eE".contains(&b)) && word.parse::<f64>().is_ok()
}

/// A number as messages show it: `25`, `0.04`, and `1e-300` where it would have hundreds of digits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Short(pub f64);

impl Display for Short {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self(number) = *self;
        match number.abs() {
            0.0 | 1e-5..1e16 => write!(f, "{number}"),
            _ => write!(f, "{number:e}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers() {
        let cases = [
            ("0", 0.0),
            (".1", 0.1),
            ("-.5", -0.5),
            ("08", 8.0),
            ("1.", 1.0),
            ("2e-3", 0.002),
            ("+4E2", 400.0),
            ("-0", 0.0),
            ("1e-400", 0.0),
        ];
        for (word, value) in cases {
            assert!(looks_like_number(word), "{word}");
            assert_eq!(parse_number(word), Ok(value), "{word}");
        }
    }

    #[test]
    fn numbers_of_any_size_are_short() {
        let shown = [0.0, 25.0, 0.04, -12.5, 1e-5, 1e15].map(|number| Short(number).to_string());
        assert_eq!(shown, ["0", "25", "0.04", "-12.5", "0.00001", "1000000000000000"]);
        let shown = [1e-300, -2.5e300, 1e16, 9e-6].map(|number| Short(number).to_string());
        assert_eq!(shown, ["1e-300", "-2.5e300", "1e16", "9e-6"]);
    }

    fn help(word: &str) -> String {
        assert!(looks_like_number(word), "{word}");
        parse_number(word).unwrap_err().help.unwrap_or_default()
    }

    #[test]
    fn mistakes_are_explained() {
        assert_eq!(help("0,5"), "write `0.5`");
        assert_eq!(help("-,5"), "write `-.5`");
        assert_eq!(help("1,"), "write `1`, without the comma");
        assert_eq!(help("1,2,3"), "write `1 2 3`");
        assert_eq!(help("\u{2212}5"), "write `-5` with a plain minus");
        assert_eq!(help("\u{2013}.5"), "write `-.5` with a plain minus");
        assert_eq!(help("32#samples"), "put white space in front of the comment: `32 #samples`");
        assert_eq!(help("1;"), "write `1`, without the semicolon");
        assert_eq!(help("2%"), "a share is a number from 0 to 1, write `0.02`");
        assert_eq!(help("100%"), "a share is a number from 0 to 1, write `1`");
        assert_eq!(help("5cm"), "a number has no unit, write `5`");
    }

    #[test]
    fn words_that_are_no_numbers() {
        for word in
            ["1e999", "nan", "-inf", "Infinity", "0x10", "1.2.3", "1-2", ".", "-", "1e", "e5x"]
        {
            assert!(parse_number(word).is_err(), "{word}");
        }
        for word in ["difuse", "e5", "infinite", "světlo", "_1"] {
            assert!(!looks_like_number(word), "{word}");
        }
    }
}
