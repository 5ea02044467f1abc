//! How far a rendering is: a bar on a terminal, lines elsewhere.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::interrupt;
use super::terminal::{Terminal, Verbosity, say};
use crate::render::Observer;

/// Watches a rendering; takes itself off the screen when dropped.
pub(super) struct Progress {
    total: u64,
    done: AtomicU64,
    start: Instant,
    view: View,
}

enum View {
    Nothing,
    Bar(ProgressBar),
    Lines(Mutex<Pace>),
}

impl Progress {
    /// For a picture of `total` pixels that is called `title`.
    pub(super) fn new(total: u64, title: &str, terminal: Terminal) -> Self {
        let view = match terminal {
            Terminal { verbosity: Verbosity::Quiet, .. } => View::Nothing,
            Terminal { interactive: true, .. } => View::Bar(bar(total, title, terminal.color)),
            _ => View::Lines(Mutex::default()),
        };
        Self { total, done: AtomicU64::new(0), start: Instant::now(), view }
    }

    fn line(&self, done: u64, pace: &mut Pace) {
        let elapsed = self.start.elapsed();
        let fraction = done as f64 / self.total.max(1) as f64;
        if pace.is_due(fraction, elapsed) {
            let left = elapsed.mul_f64((1.0 - fraction).max(0.0) / fraction);
            say(format_args!(
                "slo-rt: {:3.0} %, {} passed, about {} left",
                fraction * 100.0,
                human(elapsed),
                human(Duration::from_secs(left.as_secs_f64().round() as u64))
            ));
        }
    }
}

impl Observer for Progress {
    fn advanced(&self, pixels: u64, _samples: u64) {
        let done = self.done.fetch_add(pixels, Ordering::Relaxed) + pixels;
        match &self.view {
            View::Nothing => {}
            View::Bar(bar) => bar.set_position(done),
            View::Lines(pace) => {
                // A thread that finds another one talking has nothing to add.
                if let Ok(mut pace) = pace.try_lock() {
                    self.line(done, &mut pace);
                }
            }
        }
    }

    fn should_stop(&self) -> bool {
        interrupt::requested()
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let View::Bar(bar) = &self.view {
            bar.finish_and_clear();
        }
    }
}

fn bar(total: u64, title: &str, color: bool) -> ProgressBar {
    let color = if color { ".cyan" } else { "" };
    let template =
        format!("{{msg}} [{{bar:30{color}}}] {{percent:>3}} %, {{elapsed}} passed, {{eta}} left");
    let style = ProgressStyle::with_template(&template);
    let style = style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> ");
    let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::stderr_with_hz(8));
    bar.set_style(style);
    bar.set_message(title.to_owned());
    bar.enable_steady_tick(Duration::from_millis(500));
    bar
}

/// When to print another line: every tenth of the picture, but not more often than every three
/// seconds, and every minute however slow it goes.
#[derive(Debug, Default)]
struct Pace {
    fraction: f64,
    elapsed: Duration,
}

impl Pace {
    /// Whether a line is due; counts from here if so. None is due at the end, which the summary
    /// tells.
    fn is_due(&mut self, fraction: f64, elapsed: Duration) -> bool {
        let since = elapsed.saturating_sub(self.elapsed);
        let tenths = |fraction: f64| (fraction * 10.0).floor();
        let far = tenths(fraction) > tenths(self.fraction) && since >= Duration::from_secs(3);
        let long = fraction > self.fraction && since >= Duration::from_secs(60);
        let due = fraction < 1.0 && (far || long);
        if due {
            *self = Self { fraction, elapsed };
        }
        due
    }
}

/// A duration for people: `0.31 s`, `4 s`, `12 s`, `4 min 05 s`, `3 h 12 min`.
pub(super) fn human(duration: Duration) -> String {
    let seconds = duration.as_secs_f64();
    match seconds.round() as u64 {
        _ if seconds < 9.995 && duration.subsec_nanos() > 0 => format!("{seconds:.2} s"),
        whole @ ..60 => format!("{whole} s"),
        whole @ ..3600 => format!("{} min {:02} s", whole / 60, whole % 60),
        whole => format!("{} h {:02} min", whole / 3600, whole / 60 % 60),
    }
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
    }

    /// Seconds at which a picture of `total` seconds, in steps of `step`, prints a line.
    fn lines(total: u64, step: u64) -> Vec<u64> {
        let mut pace = Pace::default();
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
