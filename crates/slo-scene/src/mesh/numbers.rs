//! Words that programs write for NaN and infinity.

/// Characters of the longest word that is checked.
const MOST: usize = 1000;

/// Whether the word stands for NaN, infinity or a number that is too large for f64: `nan`, `-inf`,
/// `-nan(ind)`, `1.#QNAN`, `-1.#IND00`, `1e999`.
pub(super) fn is_not_finite(word: &str) -> bool {
    if word.len() > MOST {
        return false;
    }
    if word.parse::<f64>().is_ok_and(|value| !value.is_finite()) {
        return true;
    }
    let word = word.trim_start_matches(['+', '-']).to_ascii_lowercase();
    ["1.#i", "1.#q", "1.#s", "1.#n", "1.#j", "1.#r"].iter().any(|start| word.starts_with(start))
        || matches!(word.as_str(), "nan" | "inf" | "infinity" | "nan(ind)" | "nan(snan)" | "qnan")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_spelling_is_known() {
        let spellings = [
            "nan",
            "NaN",
            "-nan",
            "inf",
            "-Infinity",
            "-nan(ind)",
            "nan(snan)",
            "1.#QNAN",
            "1.#INF",
            "-1.#IND00",
            "1.#J",
            "-1.#R",
            "1e999",
            "-1e999",
        ];
        for word in spellings {
            assert!(is_not_finite(word), "{word}");
        }
        for word in ["1", "1.", "1.#", "nano", "infix", "1.#1", "", "-"] {
            assert!(!is_not_finite(word), "{word}");
        }
    }
}
