//! Words and numbers of a file that is read as bytes, by the rules of scene texts.

use super::number::{NumberError, parse_number};

/// Characters of a word that a message quotes.
pub(crate) const QUOTED: usize = 60;

/// Whether the byte is white space.
pub(crate) fn is_space(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t'..=b'\r')
}

/// Whether a word ends in front of the byte.
pub(crate) fn ends_word(byte: u8) -> bool {
    is_space(byte) || matches!(byte, b'{' | b'}')
}

/// Bytes of the white space at the start of `bytes`.
pub(crate) fn blank_len(bytes: &[u8]) -> usize {
    let mut len = 0;
    while let Some(&byte) = bytes.get(len) {
        match is_space(byte) {
            true => len += 1,
            false if byte.is_ascii() => break,
            false => match wide_space_len(&bytes[len..]) {
                0 => break,
                wide => len += wide,
            },
        }
    }
    len
}

/// Bytes of the word at the start of `bytes`.
pub(crate) fn word_len(bytes: &[u8]) -> usize {
    let ends =
        |(i, &b): (usize, &u8)| ends_word(b) || (b > 0x7F && wide_space_len(&bytes[i..]) > 0);
    bytes.iter().enumerate().position(ends).unwrap_or(bytes.len())
}

/// Bytes of the white space outside of ASCII that `bytes` start with, such as a no-break space.
fn wide_space_len(bytes: &[u8]) -> usize {
    let is_wide_space = |len: &usize| {
        let first = bytes.get(..*len).and_then(|b| str::from_utf8(b).ok());
        first.is_some_and(|text| text.trim().is_empty())
    };
    (2..=3).find(is_wide_space).unwrap_or(0)
}

/// The number at the start of `bytes` and its length, if it is finite and the end of its word
/// can be seen. `None` does not mean that it is not a number.
#[inline]
pub(crate) fn quick_f64(bytes: &[u8]) -> Option<(f64, usize)> {
    let (value, len) = fast_float2::parse_partial::<f64, _>(bytes).ok()?;
    (value.is_finite() && ends_word(*bytes.get(len)?)).then_some((value, len))
}

/// As [`quick_f64`] for a whole number below 10^9.
#[inline]
pub(crate) fn quick_u32(bytes: &[u8]) -> Option<(u32, usize)> {
    let mut value = 0;
    for (len, &byte) in bytes.iter().enumerate().take(10) {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 {
            return (len > 0 && ends_word(byte)).then_some((value, len));
        }
        if len == 9 {
            return None;
        }
        value = 10 * value + u32::from(digit);
    }
    None
}

/// The f64 nearest to what the word says.
///
/// # Errors
/// It is no number in the notation of scenes; a long word is cut in the message.
pub(crate) fn parse_word(word: &[u8]) -> Result<f64, NumberError> {
    let text = String::from_utf8_lossy(word);
    parse_number(&text).map_err(|error| match text.char_indices().nth(QUOTED) {
        None => error,
        Some((end, _)) => {
            NumberError { message: format!("`{}...` is not a number", &text[..end]), help: None }
        }
    })
}

#[cfg(test)]
mod tests {
    use rand::rngs::StdRng;
    use rand::{RngExt, SeedableRng};

    use super::*;

    /// Both ways of reading a word.
    fn read(word: &str) -> [Option<f64>; 2] {
        let ended = format!("{word} ");
        [quick_f64(ended.as_bytes()).map(|q| q.0), parse_word(word.as_bytes()).ok()]
    }

    #[track_caller]
    fn check(word: &str, expected: f64) {
        for read in read(word) {
            assert_eq!(read.map(f64::to_bits), Some(expected.to_bits()), "`{word}`");
        }
    }

    #[test]
    fn every_notation_of_the_language_is_a_number() {
        check(".1", 0.1);
        check("-.5", -0.5);
        check("08", 8.0);
        check("1.", 1.0);
        check("2e-3", 0.002);
        check("+2E+3", 2000.0);
        check("-0", -0.0);
    }

    #[test]
    fn hard_cases_are_rounded_to_the_nearest() {
        // Half way between two f64, with and without a last digit that decides.
        check("9007199254740993", 9007199254740992.0);
        check("9007199254740993.00000000000000000000000001", 9007199254740994.0);
        check("2.2250738585072011e-308", 2.225073858507201e-308);
        check("5e-324", f64::from_bits(1));
        check("1.7976931348623157e308", f64::MAX);
        check("0.1000000000000000055511151231257827021181583404541015625", 0.1);
        check(&format!("0.{}1", "0".repeat(400)), 0.0);
    }

    #[test]
    fn random_numbers_are_what_the_standard_library_reads() {
        let mut rng = StdRng::seed_from_u64(3);
        for _ in 0..100_000 {
            let digits: u64 = rng.random::<u64>() >> rng.random_range(0..64);
            let fraction: u64 = rng.random::<u64>() >> rng.random_range(0..64);
            let exponent: i32 = rng.random_range(-330..300);
            for word in [
                format!("{digits}.{fraction}"),
                format!("-{digits}e{exponent}"),
                format!("{digits}.{fraction}e{exponent}"),
                format!(".{fraction:020}"),
            ] {
                let expected: f64 = word.parse().expect("a number");
                if expected.is_finite() {
                    check(&word, expected);
                } else {
                    assert_eq!(read(&word), [None; 2], "`{word}`");
                }
            }
        }
    }

    #[test]
    fn other_words_are_no_numbers() {
        let faulty = ["", "-", ".", "e5", "1e", "1e+", "1.2.3", "0x10", "1_000", "--1", "1-", "½"];
        for word in faulty {
            assert!(parse_word(word.as_bytes()).is_err(), "`{word}`");
            assert_eq!(quick_f64(format!("{word} ").as_bytes()), None, "`{word}`");
        }
    }

    #[test]
    fn a_number_at_the_end_of_what_is_known_may_go_on() {
        assert_eq!(quick_f64(b"1.5"), None);
        assert_eq!(quick_u32(b"15"), None);
        assert_eq!(quick_u32(b"15}"), Some((15, 2)));
        assert_eq!(quick_u32(b"999999999 "), Some((999_999_999, 9)));
        assert_eq!(quick_u32(b"1000000000 "), None);
    }

    #[test]
    fn white_space_is_unicodes() {
        let text = " \t\u{a0}\u{2003}\u{3000}word\u{a0}next";
        let word = &text.as_bytes()[blank_len(text.as_bytes())..];
        assert_eq!(&word[..word_len(word)], b"word");
        assert_eq!(word_len("ř\u{2028}".as_bytes()), 2);
        assert_eq!(word_len(b"\xC2"), 1);
    }

    #[test]
    fn long_words_are_cut_in_messages() {
        let error = parse_word("ř".repeat(1000).as_bytes()).expect_err("no number");
        assert!(error.message.len() < 200, "{}", error.message);
        assert_eq!(parse_word(format!("{}1", "0".repeat(1000)).as_bytes()), Ok(1.0));
    }
}
