//! How many requests are answered.

use std::time::{Duration, Instant};

/// Allows a number of requests a second, and as many at once.
#[derive(Debug)]
pub(super) struct Rate {
    per_second: f64,
    left: f64,
    at: Instant,
}

impl Rate {
    pub(super) fn new(per_second: f64) -> Self {
        Self { per_second, left: per_second, at: Instant::now() }
    }

    /// Whether one more request is answered.
    pub(super) fn allows(&mut self) -> bool {
        let now = Instant::now();
        let passed = now.saturating_duration_since(self.at);
        self.at = now;
        self.take(passed)
    }

    fn take(&mut self, passed: Duration) -> bool {
        self.left = (self.left + passed.as_secs_f64() * self.per_second).min(self.per_second);
        let allows = self.left >= 1.0;
        if allows {
            self.left -= 1.0;
        }
        allows
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flood_is_cut_off_and_forgiven() {
        let mut rate = Rate::new(5.0);
        let now = |rate: &mut Rate| (0..20).filter(|_| rate.take(Duration::ZERO)).count();
        assert_eq!(now(&mut rate), 5);
        assert_eq!(now(&mut rate), 0);
        assert!(rate.take(Duration::from_millis(250)) && !rate.take(Duration::ZERO));
        assert!(rate.take(Duration::from_secs(60)));
        assert_eq!(now(&mut rate), 4);
    }
}
