//! Shows how far a run is: a bar on a terminal, lines elsewhere, events for programs.

mod estimate;
mod pace;
mod programs;

use std::mem;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::cli::base::{Problem, Terminal, Verbosity, human, say, whole};
use crate::cli::values::ProgressForm;
use estimate::{Estimate, Moment};
use pace::Pace;
use programs::Event;
use slo_picture::output::Outcome;

/// Shows how far a run is. When dropped, disappears from the screen.
pub(crate) struct Progress {
    view: View,
    estimate: Mutex<Estimate>,
    is_shared: bool,
    frames: usize,
    /// Number of frames that are done; a picture may still be on its way to the disk.
    done: AtomicUsize,
    beside: Mutex<Beside>,
    pace: Mutex<Pace>,
    /// What is being made, if it is not a frame.
    name: Option<String>,
}

/// What stands beside the frame in progress. Events come frame by frame: that a frame has started
/// is told after the picture before it is finished.
enum Beside {
    Nothing,
    /// The picture of the last frame is being written.
    Picture,
    /// So it is, and the next frame has started: its number, path and index.
    PictureAndStart(i64, PathBuf, usize),
}

enum View {
    Nothing,
    Bar(ProgressBar),
    Lines,
    Programs(fn(Event) -> Vec<String>),
}

/// Number of steps of the bar.
const STEPS: u64 = 10_000;

impl Progress {
    /// Starts the progress of a run that renders `to_render` of `frames` frames, alone or with
    /// others.
    pub(crate) fn new(
        form: ProgressForm,
        is_shared: bool,
        frames: usize,
        to_render: usize,
        terminal: Terminal,
    ) -> Self {
        let quiet = terminal.verbosity == Verbosity::Quiet;
        let view = match form {
            ProgressForm::Json => View::Programs(|event| vec![programs::json_line(event)]),
            ProgressForm::Openjd => View::Programs(programs::openjd_lines),
            ProgressForm::None => View::Nothing,
            _ if quiet => View::Nothing,
            ProgressForm::Auto if terminal.interactive => View::Bar(bar(terminal.color)),
            ProgressForm::Auto | ProgressForm::Plain => View::Lines,
        };
        let pace = match view {
            View::Programs(_) => Pace::programs(),
            _ => Pace::people(),
        };
        let (estimate, pace) = (Mutex::new(Estimate::new(to_render)), Mutex::new(pace));
        let done = AtomicUsize::new(0);
        let beside = Mutex::new(Beside::Nothing);
        let progress =
            Self { view, estimate, is_shared, frames: to_render, done, beside, pace, name: None };
        progress.tell(Event::Sequence { frames, to_render });
        progress
    }

    /// Measures the work by the clock from now on: it is done when `span` is over.
    pub(crate) fn by_clock(&mut self, span: Duration) {
        self.estimate = Mutex::new(Estimate::of_time(span));
    }

    /// Names what is made next, which is not a frame.
    pub(crate) fn call(&mut self, name: String) {
        self.name = Some(name);
    }

    /// Names what is being made.
    fn name(&self, frame: i64) -> String {
        self.name.clone().unwrap_or_else(|| format!("frame {frame}"))
    }

    /// Moves to one of the frames to be rendered, by its place among them, 0 for the first.
    pub(crate) fn go_to(&mut self, place: usize) {
        *self.done.get_mut() = place;
    }

    /// Records that a frame has all of its samples, or that it failed. The next one may begin.
    pub(crate) fn over(&self) {
        self.done.fetch_add(1, Ordering::SeqCst);
    }

    fn done(&self) -> usize {
        self.done.load(Ordering::SeqCst)
    }

    /// Records a frame that is finished already. `counted`: it was among the frames to be
    /// rendered.
    pub(crate) fn found(&self, frame: i64, path: &Path, counted: bool) {
        if counted {
            self.over();
        }
        // Processes that share the work will continue as fast. Others may have helped just once.
        if counted && !self.is_shared {
            lock(&self.estimate).add_free(1.0);
        }
        self.tell(Event::Found { frame, path });
    }

    /// Watches the rendering of a frame.
    pub(crate) fn frame(&self, frame: i64, path: &Path) -> FrameProgress<'_> {
        let index = self.done() + 1;
        {
            let mut beside = lock(&self.beside);
            match &*beside {
                Beside::Picture => *beside = Beside::PictureAndStart(frame, path.into(), index),
                _ => self.tell(Event::Started { frame, path, index }),
            }
        }
        if let View::Bar(bar) = &self.view {
            bar.set_prefix(match self.frames {
                1 => self.name(frame),
                frames => format!("{}, {} of {frames}", self.name(frame), self.done() + 1),
            });
        }
        FrameProgress { run: self, frame, done: Mutex::new(0.0) }
    }

    /// Records that the picture of a frame that is over is written while the next frame is rendered.
    /// It will be finished, or fail, before any other frame does.
    pub(crate) fn writes_beside(&self) {
        *lock(&self.beside) = Beside::Picture;
    }

    /// Tells what happened to a picture, and then that the next frame has started, if it has. Returns
    /// whether no frame is in progress.
    fn settle(&self, event: Event) -> bool {
        let mut beside = lock(&self.beside);
        self.tell(event);
        match mem::replace(&mut *beside, Beside::Nothing) {
            Beside::PictureAndStart(frame, path, index) => {
                self.tell(Event::Started { frame, path: &path, index });
                false
            }
            _ => true,
        }
    }

    /// Records a picture that is in place. Its frame, which is [over](Self::over), took `time`. The
    /// next one may have begun.
    pub(crate) fn finished(&self, frame: i64, path: &Path, time: Duration, outcome: Outcome) {
        let run = lock(&self.estimate).at(self.done() as f64);
        if self.settle(Event::Finished { frame, path, time, outcome, run }) {
            self.show(frame, 0.0);
        }
        if matches!(self.view, View::Lines) && self.frames > 1 {
            let (done, frames) = (self.done(), self.frames);
            let (name, time, left) = (self.name(frame), human(time), left(&run));
            say(format_args!("slo-rt: {name} in {time}, {done} of {frames}{left}"));
        }
    }

    /// Records a frame that failed.
    pub(crate) fn failed(&self, frame: i64, problem: &Problem, counted: bool) {
        if counted {
            self.over();
        }
        let _ = self.settle(Event::Failed { frame, problem });
    }

    /// Reports that only frames of other processes are left.
    pub(crate) fn waiting(&self, frames: &[i64]) {
        self.tell(Event::Waiting { frames });
        if let View::Bar(bar) = &self.view {
            bar.set_prefix("waiting for others");
        }
    }

    /// Reports that the run is over after `time`.
    pub(crate) fn ended(&self, rendered: usize, found: usize, failed: usize, time: Duration) {
        self.tell(Event::Ended { rendered, found, failed, time });
    }

    /// Runs `talk` while the bar is hidden, so that it does not mix with lines.
    pub(crate) fn suspended<T>(&self, talk: impl FnOnce() -> T) -> T {
        match &self.view {
            View::Bar(bar) => bar.suspend(talk),
            _ => talk(),
        }
    }

    fn tell(&self, event: Event) {
        if let View::Programs(lines) = &self.view {
            lines(event).into_iter().for_each(say);
        }
    }

    /// Shows that `fraction` of a frame is done.
    fn show(&self, frame: i64, fraction: f64) {
        let done = self.done() as f64 + fraction;
        match &self.view {
            View::Nothing => {}
            View::Bar(bar) => {
                let moment = lock(&self.estimate).at(done);
                bar.set_position((moment.fraction * STEPS as f64) as u64);
                bar.set_message(left(&moment));
            }
            // If another thread is printing, this one has nothing to add.
            View::Lines | View::Programs(_) => {
                if let Ok(mut pace) = self.pace.try_lock() {
                    let moment = lock(&self.estimate).at(done);
                    if pace.is_due(moment.fraction, moment.elapsed) {
                        self.line(frame, fraction, moment);
                    }
                }
            }
        }
    }

    fn line(&self, frame: i64, fraction: f64, run: Moment) {
        {
            let beside = lock(&self.beside);
            if matches!(*beside, Beside::PictureAndStart(..)) {
                return;
            }
            self.tell(Event::Progress { frame, fraction, run });
        }
        if matches!(self.view, View::Lines) {
            let (elapsed, left) = (human(run.elapsed), left(&run));
            say(format_args!("slo-rt: {:3.0} %, {elapsed} passed{left}", run.fraction * 100.0));
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let View::Bar(bar) = &self.view {
            bar.finish_and_clear();
        }
    }
}

fn left(moment: &Moment) -> String {
    moment.left.map_or_else(String::new, |left| format!(", about {} left", whole(left)))
}

/// Progress of one frame.
pub(crate) struct FrameProgress<'a> {
    run: &'a Progress,
    frame: i64,
    /// Fraction of the frame that is done.
    done: Mutex<f64>,
}

impl FrameProgress<'_> {
    /// Records that `share` more of the frame is done.
    pub(crate) fn advanced(&self, share: f64) {
        let done = {
            let mut done = lock(&self.done);
            *done += share;
            *done
        };
        self.run.show(self.frame, done.min(1.0));
    }

    /// Records that `time` went into what the next `share` of the frame needs.
    pub(crate) fn prepared(&self, time: Duration, share: f64) {
        let done = self.run.done() as f64 + *lock(&self.done);
        lock(&self.run.estimate).prepared(time, done, share);
    }

    /// Records that another run has done `share` of the frame.
    pub(crate) fn resumed(&self, share: f64) {
        lock(&self.run.estimate).add_free(share);
        self.advanced(share);
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

fn bar(color: bool) -> ProgressBar {
    let color = if color { ".cyan" } else { "" };
    let template =
        format!("{{prefix}} [{{bar:30{color}}}] {{percent:>3}} %, {{elapsed}} passed{{msg}}");
    let style = ProgressStyle::with_template(&template);
    let style = style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> ");
    let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::stderr_with_hz(8));
    bar.set_style(style);
    bar.enable_steady_tick(Duration::from_millis(500));
    bar
}
