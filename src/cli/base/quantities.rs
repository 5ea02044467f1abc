//! Quantities in words: counts, times, bytes.

use std::time::Duration;

/// Formats a count of things. The plural of `name` takes an `s`.
pub(crate) fn counted(count: impl TryInto<u64>, name: &str) -> String {
    let count = count.try_into().unwrap_or(u64::MAX);
    if count == 1 { format!("1 {name}") } else { format!("{count} {name}s") }
}

/// Formats a duration for people: `0.31 s`, `4 s`, `12 s`, `4 min 05 s`, `3 h 12 min`.
pub(crate) fn human(duration: Duration) -> String {
    let seconds = duration.as_secs_f64();
    match seconds.round() as u64 {
        _ if seconds < 9.995 && duration.subsec_nanos() > 0 => format!("{seconds:.2} s"),
        whole @ ..60 => format!("{whole} s"),
        whole @ ..3600 => format!("{} min {:02} s", whole / 60, whole % 60),
        whole => format!("{} h {:02} min", whole / 3600, whole / 60 % 60),
    }
}

/// Formats a duration rounded to whole seconds.
pub(crate) fn whole(duration: Duration) -> String {
    human(Duration::from_secs(duration.as_secs_f64().round() as u64))
}

/// Formats bytes with a unit.
pub(crate) fn megabytes(bytes: u64) -> String {
    match bytes as f64 / 1e6 {
        small if small < 9.95 => format!("{small:.1} MB"),
        large => format!("{large:.0} MB"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_thing_is_no_things() {
        assert_eq!([0usize, 1, 2].map(|n| counted(n, "part")), ["0 parts", "1 part", "2 parts"]);
    }

    #[test]
    fn durations_for_people() {
        let check = |seconds: f64, expected: &str| {
            assert_eq!(human(Duration::from_secs_f64(seconds)), expected);
        };
        check(0.0, "0 s");
        check(0.005, "0.01 s");
        check(4.0, "4 s");
        check(9.99, "9.99 s");
        check(9.999, "10 s");
        check(59.4, "59 s");
        check(59.6, "1 min 00 s");
        check(3_599.6, "1 h 00 min");
        check(11_520.0, "3 h 12 min");
        assert_eq!(whole(Duration::from_millis(1400)), "1 s");
    }

    #[test]
    fn bytes_have_units() {
        assert_eq!(megabytes(0), "0.0 MB");
        assert_eq!(megabytes(1_250_000), "1.2 MB");
        assert_eq!(megabytes(12_300_000_000), "12300 MB");
    }
}
