//! Numbers as people write them.

use std::fmt::Display;
use std::ops::RangeInclusive;
use std::str::FromStr;

/// Parses a whole number: `1000`, `1_000`, `1e3`, `0x3e8`. Returns `None` for anything else, and
/// for numbers beyond 64 bits.
pub(crate) fn whole(text: &str) -> Option<u64> {
    let text = text.trim();
    let text = text.strip_prefix('+').unwrap_or(text);
    if !is_grouped(text) {
        return None;
    }
    let digits = text.replace('_', "");
    if let Some(hex) = digits.strip_prefix("0x").or_else(|| digits.strip_prefix("0X")) {
        return u64::from_str_radix(hex, 16).ok().filter(|_| !hex.starts_with('+'));
    }
    match digits.parse() {
        Ok(number) => Some(number),
        Err(_) => scientific(&digits),
    }
}

/// Whether the text begins with a digit, and underscores stand only between other characters.
fn is_grouped(text: &str) -> bool {
    text.split('_').all(|group| !group.is_empty()) && text.starts_with(|c: char| c.is_ascii_digit())
}

/// Parses `1.5e3`, if it is whole: digits, a point, and an exponent.
fn scientific(text: &str) -> Option<u64> {
    let (mantissa, exponent) = text.split_once(['e', 'E'])?;
    let exponent: usize = exponent.strip_prefix('+').unwrap_or(exponent).parse().ok()?;
    let (before, after) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let after = after.trim_end_matches('0');
    let is_digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    if before.is_empty() || !is_digits(before) || !is_digits(after) || after.len() > exponent {
        return None;
    }
    let digits: u64 = format!("{before}{after}").parse().ok()?;
    let power = 10u64.checked_pow(u32::try_from(exponent - after.len()).ok()?);
    if digits == 0 { Some(0) } else { digits.checked_mul(power?) }
}

/// Parses a whole number in a range. `example` is such a number.
///
/// # Errors
/// What is expected, in words for the user.
pub(crate) fn count<T: TryFrom<u64> + PartialOrd + Display>(
    text: &str,
    range: RangeInclusive<T>,
    example: &str,
) -> Result<T, String> {
    let found = whole(text).and_then(|number| T::try_from(number).ok());
    found.filter(|number| range.contains(number)).ok_or_else(|| {
        let (least, most) = (range.start(), range.end());
        format!("expected a whole number from {least} to {most}, such as {example}")
    })
}

/// Parses a finite number: `0.01`, `1e-2`, or `1%`.
pub(crate) fn real(text: &str) -> Option<f64> {
    let text = text.trim();
    let (text, scale) = match text.strip_suffix('%') {
        Some(percent) => (percent.trim_end(), 0.01),
        None => (text, 1.0),
    };
    // The standard library also parses words such as `nan` and `inf`.
    let is_number = text.ends_with(|c: char| c.is_ascii_digit() || c == '.');
    let number = f64::from_str(text).ok().filter(|number| is_number && number.is_finite())?;
    Some(if scale < 1.0 { number / 100.0 } else { number })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers() {
        for (text, expected) in [
            ("0", 0),
            ("64", 64),
            (" 64 ", 64),
            ("+64", 64),
            ("064", 64),
            ("1_000", 1000),
            ("1e3", 1000),
            ("1E+3", 1000),
            ("1.5e3", 1500),
            ("2.50e1", 25),
            ("0e99", 0),
            ("0x10", 16),
            ("0Xff", 255),
            ("18446744073709551615", u64::MAX),
        ] {
            assert_eq!(whole(text), Some(expected), "{text}");
        }
        for bad in [
            "",
            " ",
            "-1",
            "1.5",
            "1.55e1",
            "e3",
            "1e",
            "1e-3",
            "1e20",
            "1_",
            "_1",
            "1__0",
            "1 000",
            "0x",
            "0x+1",
            "1,000",
            "x",
            "nan",
            "inf",
            "1e99999999999999999999",
            "٣",
            "++1",
            "1e1e1",
            "18446744073709551616",
        ] {
            assert_eq!(whole(bad), None, "{bad}");
        }
    }

    #[test]
    fn numbers_out_of_their_range_are_told_it() {
        assert_eq!(count("1e3", 1..=65_535u32, "64"), Ok(1000));
        for bad in ["0", "65536", "4294967297", "-1", "x"] {
            let message = "expected a whole number from 1 to 65535, such as 64";
            assert_eq!(count(bad, 1..=65_535u32, "64"), Err(message.into()), "{bad}");
        }
    }

    #[test]
    fn numbers_and_shares() {
        for (text, expected) in [("0.01", 0.01), ("1e-2", 0.01), ("1%", 0.01), ("50 %", 0.5)] {
            assert_eq!(real(text), Some(expected), "{text}");
        }
        for bad in ["", "%", "x", "nan", "inf", "infinity", "NaN%", "1e999", "0,1", "1 2"] {
            assert_eq!(real(bad), None, "{bad}");
        }
    }
}
