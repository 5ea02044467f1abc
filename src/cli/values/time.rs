//! Spans of time as people write them.

use std::time::Duration;

use super::numbers::real;

/// Shortest time that processes may go without a sign of life: as short as a process can keep to.
pub(crate) const SHORTEST_LEASE: Duration = Duration::from_secs(1);
/// Longest time that processes may go without a sign of life: as long as somebody would wait.
pub(crate) const LONGEST_LEASE: Duration = Duration::from_secs(86_400);

const LONGEST: Duration = Duration::from_secs(100 * 365 * 86_400);

/// Parses `90`, `90s`, `1.5h`, `1h30m`, `500ms`, `1 h 30 min`; a bare number is seconds.
///
/// # Errors
/// What was expected, in words for the user.
pub(crate) fn time(text: &str) -> Result<Duration, String> {
    let time = seconds(text).filter(|time| !time.is_zero());
    time.ok_or_else(|| "expected a time such as 90s, 15m, 8h or 1h30m".into())
}

/// Parses the time between two checkpoints. 0, or a word such as `none`, means no checkpoints.
///
/// # Errors
/// What was expected, in words for the user.
pub(crate) fn interval(text: &str) -> Result<Duration, String> {
    let is_none =
        ["none", "never", "off"].iter().any(|word| text.trim().eq_ignore_ascii_case(word));
    let time = if is_none { Some(Duration::ZERO) } else { seconds(text) };
    time.ok_or_else(|| "expected a time such as 60, 90s or 5m, or 0 for no checkpoints".into())
}

/// Parses how long processes may go without a sign of life.
///
/// # Errors
/// What was expected, in words for the user.
pub(crate) fn lease(text: &str) -> Result<Duration, String> {
    let range = SHORTEST_LEASE..=LONGEST_LEASE;
    let time = seconds(text).filter(|time| range.contains(time));
    time.ok_or_else(|| "expected a time from 1 second to 24 hours, such as 60, 90s or 5m".into())
}

/// Parses a time as it is written. Returns `None` for anything else, and for times longer than a
/// century.
fn seconds(text: &str) -> Option<Duration> {
    let text = text.trim();
    if text.is_empty() {
        return None;
    }
    if let Some(seconds) = real(text).filter(|_| !text.ends_with('%')) {
        return duration(seconds);
    }
    let mut seconds = 0.0;
    let mut rest = text;
    while !rest.is_empty() {
        let end = rest.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(rest.len());
        let (number, after) = rest.split_at(end);
        let after = after.trim_start();
        let end = after.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(after.len());
        let (unit, after) = after.split_at(end);
        seconds += number.parse::<f64>().ok()? * scale(unit)?;
        rest = after.trim_start();
    }
    duration(seconds)
}

fn duration(seconds: f64) -> Option<Duration> {
    Duration::try_from_secs_f64(seconds).ok().filter(|time| *time <= LONGEST)
}

/// Returns the seconds of a unit.
fn scale(unit: &str) -> Option<f64> {
    Some(match &*unit.to_ascii_lowercase() {
        "" | "s" | "sec" | "secs" | "second" | "seconds" => 1.0,
        "ms" => 1e-3,
        "m" | "min" | "mins" | "minute" | "minutes" => 60.0,
        "h" | "hr" | "hrs" | "hour" | "hours" => 3600.0,
        "d" | "day" | "days" => 86_400.0,
        _ => return None,
    })
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
        check("1e3", 1000.0);
        check("1 h 30 min", 5400.0);
        check("2 Hours", 7200.0);
        for bad in ["", " ", "0", "0s", "x", "5x", "-5", "1.2.3s", "s", "5%", "nan", "99999999999h"]
        {
            assert!(time(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn no_time_between_checkpoints_is_none() {
        for none in ["0", "0s", "none", "Never", "off"] {
            assert_eq!(interval(none), Ok(Duration::ZERO), "{none}");
        }
        assert_eq!(interval("90s"), Ok(Duration::from_secs(90)));
        for bad in ["", "-1", "x", "auto"] {
            assert!(interval(bad).unwrap_err().contains("such as"), "{bad}");
        }
    }

    #[test]
    fn leases_have_bounds() {
        assert_eq!(lease("5m"), Ok(Duration::from_secs(300)));
        for bad in ["", "0", "0.5", "25h", "x"] {
            assert!(lease(bad).unwrap_err().contains("1 second to 24 hours"), "{bad}");
        }
    }
}
