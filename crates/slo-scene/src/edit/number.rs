//! Numbers as text.

/// Writes a number with at most so many digits behind the point, and no more than it needs.
pub fn number(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let short =
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if short == "-0" { "0".to_owned() } else { short.to_owned() }
}

/// Writes numbers that stand in one vector: all of them with the digits that the largest of them deserves.
/// `places` is the number of its significant digits.
pub fn numbers(values: &[f64], places: usize) -> String {
    let most = values.iter().fold(0.0f64, |most, value| most.max(value.abs()));
    let words: Vec<String> =
        values.iter().map(|value| number(*value, digits(most, places))).collect();
    words.join(" ")
}

/// Digits behind the point of a number of this size that has so many significant digits.
fn digits(size: f64, places: usize) -> usize {
    let mut before = 0;
    let mut size = size;
    while size >= 1.0 && before < 18 {
        size /= 10.0;
        before += 1;
    }
    let mut small = 0;
    while size > 0.0 && size < 0.1 && before == 0 && small < 18 {
        size *= 10.0;
        small += 1;
    }
    (places + small).saturating_sub(before)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        assert_eq!(number(1.5, 4), "1.5");
        assert_eq!(number(100.0, 0), "100");
        assert_eq!(number(-0.00001, 3), "0");
        assert_eq!(number(2.0, 3), "2");
        assert_eq!(numbers(&[123.456_78, 0.012_345, -1.0], 6), "123.457 0.012 -1");
        assert_eq!(numbers(&[0.001_234_56, 0.0, 0.0], 3), "0.00123 0 0");
        assert_eq!(numbers(&[0.5], 3), "0.5");
        assert_eq!(numbers(&[1e9, 1.0], 4), "1000000000 1");
    }
}
