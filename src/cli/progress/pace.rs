//! Decides when to print another line.

use std::time::Duration;

/// A line is due after every tenth of the work, but not more often than every `least`. It is also
/// due every `most`, however slow the work is.
#[derive(Debug)]
pub(super) struct Pace {
    least: Duration,
    most: Duration,
    fraction: f64,
    elapsed: Duration,
}

impl Pace {
    /// Makes the pace for people: every three seconds at most, every minute at least.
    pub(super) fn people() -> Self {
        Self::new(Duration::from_secs(3), Duration::from_secs(60))
    }

    /// Makes the pace for programs: once a second.
    pub(super) fn programs() -> Self {
        Self::new(Duration::from_secs(1), Duration::from_secs(1))
    }

    fn new(least: Duration, most: Duration) -> Self {
        Self { least, most, fraction: 0.0, elapsed: Duration::ZERO }
    }

    /// Whether a line is due. If so, the next one counts from here. No line is due at the end,
    /// which the summary reports.
    pub(super) fn is_due(&mut self, fraction: f64, elapsed: Duration) -> bool {
        let since = elapsed.saturating_sub(self.elapsed);
        let tenths = |fraction: f64| (fraction * 10.0).floor();
        let far = tenths(fraction) > tenths(self.fraction) && since >= self.least;
        let long = fraction > self.fraction && since >= self.most;
        let due = fraction < 1.0 && (far || long);
        if due {
            (self.fraction, self.elapsed) = (fraction, elapsed);
        }
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the seconds at which work of `total` seconds, in steps of `step`, prints a line.
    fn lines(total: u64, step: u64) -> Vec<u64> {
        let mut pace = Pace::people();
        let seconds = (step..=total).step_by(step as usize);
        seconds.filter(|&s| pace.is_due(s as f64 / total as f64, Duration::from_secs(s))).collect()
    }

    #[test]
    fn short_renderings_print_every_three_seconds_at_most() {
        assert_eq!(lines(2, 1), [0; 0]);
        assert_eq!(lines(10, 1), [3, 6, 9]);
    }

    #[test]
    fn long_renderings_print_every_tenth() {
        assert_eq!(lines(100, 1), [10, 20, 30, 40, 50, 60, 70, 80, 90]);
    }

    #[test]
    fn very_long_renderings_print_every_minute() {
        assert_eq!(lines(60_000, 7)[..3], [63, 126, 189]);
    }
}
