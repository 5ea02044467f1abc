//! Estimate of the time that is left.

use std::time::{Duration, Instant};

/// The work of a run, counted in frames, and its speed so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Estimate {
    start: Instant,
    /// Number of frames to do.
    total: f64,
    /// Number of frames that took no work of this run: they were found finished, or resumed.
    free: f64,
    /// Duration of the run, if it is fixed.
    span: Option<Duration>,
}

/// How far a run is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Moment {
    /// Fraction of all work that is done.
    pub(super) fraction: f64,
    pub(super) elapsed: Duration,
    /// `None` before anything is known.
    pub(super) left: Option<Duration>,
}

impl Estimate {
    /// Starts the estimate of a run of `frames` frames that starts now.
    pub(super) fn new(frames: usize) -> Self {
        Self { start: Instant::now(), total: frames as f64, free: 0.0, span: None }
    }

    /// Starts the estimate of a run that ends after `span` from now.
    pub(super) fn of_time(span: Duration) -> Self {
        Self { span: Some(span), ..Self::new(0) }
    }

    /// Adds work that was done already, in frames.
    pub(super) fn add_free(&mut self, frames: f64) {
        self.free += frames;
    }

    /// Returns how far a run is if `done` frames are done, including the free ones.
    pub(super) fn at(&self, done: f64) -> Moment {
        self.after(done, self.start.elapsed())
    }

    fn after(&self, done: f64, elapsed: Duration) -> Moment {
        if let Some(span) = self.span {
            let fraction = elapsed.as_secs_f64() / span.as_secs_f64().max(1e-9);
            let left = Some(span.saturating_sub(elapsed));
            return Moment { fraction: fraction.min(1.0), elapsed, left };
        }
        let (own, left) = (done - self.free, (self.total - done).max(0.0));
        let left = elapsed.as_secs_f64() * left / own;
        Moment {
            fraction: (done / self.total.max(1e-9)).clamp(0.0, 1.0),
            elapsed,
            left: Duration::try_from_secs_f64(left).ok().filter(|_| own > 1e-9),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_done_before_does_not_count_as_speed() {
        let mut estimate = Estimate::new(10);
        let seconds = Duration::from_secs;
        assert_eq!(estimate.after(2.5, seconds(5)).left, Some(seconds(15)));
        estimate.add_free(4.0);
        estimate.add_free(0.5);
        let moment = estimate.after(5.0, seconds(5));
        assert_eq!((moment.fraction, moment.left), (0.5, Some(seconds(50))));
        assert_eq!(estimate.after(4.5, seconds(5)).left, None);
        assert_eq!(estimate.after(10.0, seconds(55)).left, Some(seconds(0)));
    }

    #[test]
    fn a_span_of_time_passes_by_the_clock() {
        let estimate = Estimate::of_time(Duration::from_secs(80));
        let moment = estimate.after(3.0, Duration::from_secs(20));
        assert_eq!((moment.fraction, moment.left), (0.25, Some(Duration::from_secs(60))));
        let moment = estimate.after(0.0, Duration::from_secs(81));
        assert_eq!((moment.fraction, moment.left), (1.0, Some(Duration::ZERO)));
    }
}
