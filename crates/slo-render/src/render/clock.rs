//! Measures what the steps of tiles cost, and predicts whether there is time for another one.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use super::lock::lock;
use super::plan::FULL_ERROR_AT;

/// Factor by which a step may be larger than predicted from the one before it.
const SPREAD: f64 = 1.25;
/// Least expected size of a step, as a share of the samples before it. The error falls by the
/// square root of 2 from step to step, and the share of the error that is demanded rises with the
/// square root of the samples.
const LEAST_GROWTH: f64 = 0.5;
/// The same once the full error is demanded: blocks that are clean by then take no more samples.
const LEAST_LATE_GROWTH: f64 = 0.3;

/// Costs of tiles, and the deadline.
pub(super) struct Clock {
    start: Instant,
    deadline: Instant,
    tiles: Vec<Mutex<Spent>>,
    /// Most samples of a pixel.
    most: f64,
    /// Share of the time that was reported.
    told: Mutex<f64>,
}

/// Cost of a tile so far.
#[derive(Clone, Copy, Debug, Default)]
struct Spent {
    /// Seconds spent in this run.
    time: f64,
    /// Samples per pixel taken in this time.
    taken: f64,
    /// All samples per pixel, including earlier runs.
    samples: f64,
    /// All samples per pixel before the last step that took any.
    before: f64,
}

impl Clock {
    /// Starts the clock. A pixel takes `most` samples at most.
    pub(super) fn new(deadline: Instant, tiles: usize, most: u32) -> Self {
        let tiles = (0..tiles).map(|_| Mutex::default()).collect();
        let (start, told) = (Instant::now(), Mutex::new(0.0));
        Self { start, deadline, tiles, most: most.into(), told }
    }

    /// Whether a tile has time for another step.
    pub(super) fn allows(&self, tile: usize) -> bool {
        let expected = self.tiles.get(tile).map_or(0.0, |spent| lock(spent).next(self.most));
        let left = self.deadline.checked_duration_since(Instant::now());
        left.is_some_and(|left| expected <= left.as_secs_f64())
    }

    /// Whether all tiles together have time for another step on so many threads.
    pub(super) fn allows_all(&self, threads: usize) -> bool {
        let expected: f64 = self.tiles.iter().map(|spent| lock(spent).next(self.most)).sum();
        let left = self.deadline.checked_duration_since(Instant::now());
        left.is_some_and(|left| expected / threads.max(1) as f64 <= left.as_secs_f64())
    }

    /// Whether the time is over.
    pub(super) fn is_over(&self) -> bool {
        Instant::now() >= self.deadline
    }

    /// Adds the cost of a step of a tile; `samples` are the samples per pixel before and after it.
    pub(super) fn add(&self, tile: usize, cost: Duration, samples: [f64; 2]) {
        lock(&self.tiles[tile]).add(cost, samples);
    }

    /// Returns the share of the time that has passed since the last call.
    pub(super) fn share(&self) -> f64 {
        let all = self.deadline.saturating_duration_since(self.start).as_secs_f64().max(1e-3);
        let now = (self.start.elapsed().as_secs_f64() / all).min(1.0);
        let mut told = lock(&self.told);
        let more = (now - *told).max(0.0);
        *told += more;
        more
    }
}

impl Spent {
    fn add(&mut self, cost: Duration, [before, samples]: [f64; 2]) {
        self.time += cost.as_secs_f64();
        self.samples = samples;
        if samples > before {
            self.taken += samples - before;
            self.before = before;
        }
    }

    /// Estimates the seconds of the next step; 0 if nothing is known.
    fn next(&self, most: f64) -> f64 {
        if self.taken == 0.0 {
            return 0.0;
        }
        let more = (self.samples * self.growth()).min(most - self.samples);
        self.time / self.taken * more.max(0.0)
    }

    /// Estimates the samples of the next step as a share of the samples before it: 1 at most, and 1
    /// if nothing is known.
    fn growth(&self) -> f64 {
        if self.before == 0.0 {
            return 1.0;
        }
        let last = SPREAD * (self.samples / self.before - 1.0);
        let full = f64::from(FULL_ERROR_AT);
        if self.samples < full / 2.0 {
            last.clamp(LEAST_GROWTH, 1.0)
        } else if self.before > full {
            last.clamp(LEAST_LATE_GROWTH, 1.0)
        } else {
            // Steps get larger between the two rules.
            1.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cost of a tile that took a step from `before` to `samples`, in 60 seconds in all.
    fn spent(before: f64, samples: f64) -> Spent {
        let mut spent = Spent::default();
        spent.add(Duration::from_secs(40), [0.0, before]);
        spent.add(Duration::from_secs(20), [before, samples]);
        spent
    }

    #[test]
    fn a_tile_that_would_take_too_long_is_not_begun() {
        let clock = Clock::new(Instant::now() + Duration::from_secs(100), 2, 4096);
        assert!(clock.allows(0) && clock.allows(1));
        clock.add(1, Duration::from_secs(120), [0.0, 1.0]);
        assert!(clock.allows(0) && !clock.allows(1));
        let over = Clock::new(Instant::now() - Duration::from_millis(1), 1, 4096);
        assert!(!over.allows(0));
    }

    #[test]
    fn a_step_takes_what_the_last_one_lets_expect() {
        let check = |before: f64, samples: f64, expected: f64| {
            let next = spent(before, samples).next(4096.0);
            assert!((next - expected).abs() < 1e-9, "{before} to {samples}: {next}");
        };
        check(4.0, 8.0, 60.0);
        check(71.0, 100.0, 60.0 * SPREAD * 29.0 / 71.0);
        check(99.0, 100.0, 60.0 * LEAST_GROWTH);
        check(150.0, 200.0, 60.0);
        check(1000.0, 1010.0, 60.0 * LEAST_LATE_GROWTH);
        check(1000.0, 1600.0, 60.0 * SPREAD * 0.6);
        check(1000.0, 2000.0, 60.0);
        check(1500.0, 3000.0, 60.0 / 3000.0 * 1096.0);
    }

    #[test]
    fn samples_of_an_earlier_run_cost_as_much_as_those_of_this() {
        let mut spent = Spent::default();
        spent.add(Duration::ZERO, [100.0, 100.0]);
        assert_eq!(spent.next(4096.0), 0.0);
        spent.add(Duration::from_secs(10), [100.0, 150.0]);
        assert!((spent.next(4096.0) - 30.0).abs() < 1e-9, "{}", spent.next(4096.0));
    }
}
