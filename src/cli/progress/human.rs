//! Times for people.

use std::time::Duration;

/// A duration for people: `0.31 s`, `4 s`, `12 s`, `4 min 05 s`, `3 h 12 min`.
pub(in crate::cli) fn human(duration: Duration) -> String {
    let seconds = duration.as_secs_f64();
    match seconds.round() as u64 {
        _ if seconds < 9.995 && duration.subsec_nanos() > 0 => format!("{seconds:.2} s"),
        whole @ ..60 => format!("{whole} s"),
        whole @ ..3600 => format!("{} min {:02} s", whole / 60, whole % 60),
        whole => format!("{} h {:02} min", whole / 3600, whole / 60 % 60),
    }
}

/// A duration without parts of a second.
pub(super) fn whole(duration: Duration) -> String {
    human(Duration::from_secs(duration.as_secs_f64().round() as u64))
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
