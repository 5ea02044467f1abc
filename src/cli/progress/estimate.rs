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
    ahead: Ahead,
}

/// Work that later work needs: its time belongs to that as it is done.
#[derive(Clone, Copy, Debug, Default)]
struct Ahead {
    time: Duration,
    /// Number of frames that were done before, and of those that need it.
    done: f64,
    frames: f64,
}

impl Ahead {
    /// Returns the seconds of the work that are not needed yet if `done` frames are done.
    fn left(&self, done: f64) -> f64 {
        let used = (done - self.done) / self.frames.max(1e-9);
        self.time.as_secs_f64() * (1.0 - used.clamp(0.0, 1.0))
    }
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
        Self {
            start: Instant::now(),
            total: frames as f64,
            free: 0.0,
            span: None,
            ahead: Ahead::default(),
        }
    }

    /// Starts the estimate of a run that ends after `span` from now.
    pub(super) fn of_time(span: Duration) -> Self {
        Self { span: Some(span), ..Self::new(0) }
    }

    /// Adds work that was done already, in frames.
    pub(super) fn add_free(&mut self, frames: f64) {
        self.free += frames;
    }

    /// Records that `time` went into what the next `frames` frames need, after `done` frames. What was
    /// recorded before has been used.
    pub(super) fn prepared(&mut self, time: Duration, done: f64, frames: f64) {
        self.ahead = Ahead { time, done, frames };
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
        let ahead = self.ahead.left(done).min(elapsed.as_secs_f64());
        let left = ((elapsed.as_secs_f64() - ahead) * left / own - ahead).max(0.0);
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

    /// A minute for the photons of a frame of 100 seconds, in one piece and in four.
    #[test]
    fn what_is_prepared_for_later_work_is_part_of_it() {
        let seconds = |seconds: f64| Duration::from_secs_f64(seconds);
        let left = |estimate: &Estimate, done: f64, elapsed: f64| {
            estimate.after(done, seconds(elapsed)).left.map(|left| left.as_secs_f64().round())
        };
        let mut whole = Estimate::new(3);
        whole.prepared(seconds(60.0), 0.0, 1.0);
        assert_eq!(left(&whole, 0.0, 60.0), None);
        assert_eq!(left(&whole, 0.01, 60.4), Some(239.6_f64.round()));
        assert_eq!(left(&whole, 1.0, 100.0), Some(200.0));
        whole.prepared(seconds(60.0), 1.0, 1.0);
        assert_eq!(left(&whole, 1.5, 180.0), Some(120.0));
        let mut parts = Estimate::new(1);
        parts.prepared(seconds(15.0), 0.0, 0.25);
        assert_eq!(left(&parts, 0.05, 17.0), Some(83.0));
        parts.prepared(seconds(15.0), 0.25, 0.25);
        assert_eq!(left(&parts, 0.25, 40.0), Some(60.0));
        assert_eq!(left(&parts, 0.5, 50.0), Some(50.0));
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
