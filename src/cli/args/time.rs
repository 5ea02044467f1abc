//! Spans of time as people write them.

use std::time::Duration;

/// Parses `90`, `90s`, `1.5h`, `1h30m`, `500ms`; a bare number is seconds.
///
/// # Errors
/// What was expected, in words for the user.
pub(in crate::cli) fn time(text: &str) -> Result<Duration, String> {
    let wrong = || "expected a time such as 90s, 15m, 8h or 1h30m".to_owned();
    let mut seconds = 0.0;
    let mut rest = text.trim();
    while !rest.is_empty() {
        let end = rest.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(rest.len());
        let (number, after) = rest.split_at(end);
        let end = after.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(after.len());
        let (unit, after) = after.split_at(end);
        let scale = match unit {
            "" | "s" => 1.0,
            "ms" => 1e-3,
            "m" | "min" => 60.0,
            "h" => 3600.0,
            "d" => 86_400.0,
            _ => return Err(wrong()),
        };
        seconds += number.parse::<f64>().map_err(|_| wrong())? * scale;
        rest = after;
    }
    let time = Duration::try_from_secs_f64(seconds).map_err(|_| wrong())?;
    let longest = Duration::from_secs(100 * 365 * 86_400);
    if time.is_zero() || time > longest { Err(wrong()) } else { Ok(time) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times() {
        let check = |text: &str, seconds: f64| {
            assert_eq!(time(text), Ok(Duration::from_secs_f64(seconds)), "{text}");
        };
        check("90", 90.0);
        check("90s", 90.0);
        check("1.5h", 5400.0);
        check("1h30m", 5400.0);
        check("500ms", 0.5);
        check("2d", 172_800.0);
        for bad in ["", "0", "x", "5x", "-5", "1.2.3s", "s", "1e3", "99999999999h"] {
            assert!(time(bad).is_err(), "{bad}");
        }
    }
}
