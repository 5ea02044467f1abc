//! Sizes of files and folders.

use super::numbers::real;

/// Units, the longer ones first.
const UNITS: [(&str, f64); 9] = [
    ("KiB", 1024.0),
    ("MiB", 1_048_576.0),
    ("GiB", 1_073_741_824.0),
    ("TiB", 1_099_511_627_776.0),
    ("KB", 1e3),
    ("MB", 1e6),
    ("GB", 1e9),
    ("TB", 1e12),
    ("B", 1.0),
];

/// More is a mistake.
const MOST: f64 = 1e18;

/// Parses a number of bytes with its unit.
pub(crate) fn bytes(text: &str) -> Result<u64, String> {
    let text = text.trim();
    let lower = text.to_lowercase();
    let unit = UNITS.iter().find(|(unit, _)| lower.ends_with(&unit.to_lowercase()));
    let number = unit.and_then(|(unit, bytes)| {
        let number = lower[..lower.len() - unit.len()].trim();
        let number = real(number).filter(|_| !number.ends_with('%'))?;
        Some(number * bytes).filter(|bytes| *bytes >= 0.0)
    });
    match number {
        Some(bytes) if bytes < MOST => Ok(bytes as u64),
        Some(_) => Err("expected at most 1000000TB, such as 20GB".into()),
        None => Err("expected a size with its unit (B, KB to TB, KiB to TiB), such as 20GB".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_units() {
        for (text, expected) in [
            ("20GB", 20_000_000_000),
            ("1.5 gib", 1_610_612_736),
            ("500 MiB", 524_288_000),
            ("0B", 0),
            ("7KB", 7000),
        ] {
            assert_eq!(bytes(text), Ok(expected), "{text}");
        }
        for text in ["", "20", "GB", "-1GB", "20G", "20%B", "1e9TB", "nan B"] {
            assert!(bytes(text).is_err(), "{text}");
        }
    }
}
