//! A run in progress: what it does for each frame, and its overall result.

use std::collections::BTreeSet;
use std::fmt::Display;
use std::io;
use std::mem;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard};
use std::time::{Duration, SystemTime};

use super::desk::Desk;
use super::done::{Done, Place, exit_of};
use super::frame::{Studio, Taken};
use super::plan::{self, State, Step};
use super::summary::Summary;
use super::target::not_ours;
use crate::cli::base::{Exit, Problem, counted, print};
use crate::cli::files::load;
use crate::cli::progress::Progress;
use crate::cli::system::interrupt;
use crate::cli::values::shown;
use slo_picture::output::Found;
use slo_render::frame::FrameScene;

/// A picture that was in place.
struct Placed {
    frame: i64,
    path: PathBuf,
    stamp: Option<Stamp>,
}

/// Length and modification time, which distinguish a file from another one of the same name
/// without reading either.
#[derive(PartialEq, Eq)]
struct Stamp(u64, SystemTime);

impl Placed {
    fn new(frame: i64, path: &Path) -> Self {
        Self { frame, path: path.to_owned(), stamp: Stamp::of(path) }
    }
}

impl Stamp {
    fn of(path: &Path) -> Option<Self> {
        let there = path.metadata().ok()?;
        Some(Self(there.len(), there.modified().ok()?))
    }
}

/// A run in progress. Pictures that are written beside rendering are recorded by their threads.
pub(super) struct Run<'a> {
    pub(super) studio: Studio<'a>,
    /// Number of frames that were asked for.
    frames: usize,
    is_sequence: bool,
    pub(super) progress: Progress,
    record: Mutex<Record>,
    /// Why the run took longer than its time.
    pub(super) late: Option<String>,
    /// What was built for the last frame.
    pub(super) before: Option<FrameScene>,
}

/// What a run has done so far.
pub(super) struct Record {
    summary: Summary,
    /// Number of frames that were finished already.
    pub(super) found: usize,
    pub(super) failures: Vec<(i64, Problem)>,
    /// Pictures that are in place.
    placed: Vec<Placed>,
    /// Why a path could not be printed.
    unprinted: Option<io::Error>,
}

impl Record {
    /// Adds what was done beside rendering.
    pub(super) fn beside(&mut self, desk: Desk<'_>) {
        self.summary.waited(desk.waited);
        if let Some(ahead) = desk.ahead() {
            self.summary.built_ahead(ahead.time, ahead.refused);
        }
    }
}

impl<'a> Run<'a> {
    /// Starts a run of `frames` frames, of which `to_render` are to be rendered. Reading the scene
    /// took `loading`.
    pub(super) fn new(
        studio: Studio<'a>,
        frames: usize,
        to_render: usize,
        loading: Duration,
    ) -> Self {
        let (job, terminal) = (studio.job, studio.terminal);
        let is_shared = job.share.is_some();
        let progress = Progress::new(job.progress, is_shared, frames, to_render, terminal);
        let record = Record {
            summary: Summary::new(loading, job.isa),
            found: 0,
            failures: Vec::new(),
            placed: Vec::new(),
            unprinted: None,
        };
        Self {
            studio,
            frames,
            is_sequence: frames > 1,
            progress,
            record: Mutex::new(record),
            late: None,
            before: None,
        }
    }

    pub(super) fn record(&self) -> MutexGuard<'_, Record> {
        self.record.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    /// Records a frame that is not rendered, or not again.
    pub(super) fn settle(&self, frame: i64, path: &Path, state: &State, counted: bool) {
        match state {
            State::Finished => self.keep(frame, path, counted),
            State::None(error) => self.fail(frame, load::no_segment(error), counted),
            State::Foreign(why) => self.fail(frame, not_ours(path, why), counted),
            State::ToRender(_) => {}
        }
    }

    /// Returns the path and the state of a frame that is no longer to be rendered, since another
    /// process has finished it, or somebody has put another file in its place.
    pub(super) fn state_now(&self, step: &Step) -> Option<(PathBuf, State)> {
        let now = plan::look_again(self.studio.job, &self.studio.target, step.frame);
        (!matches!(now.1, State::ToRender(_) | State::None(_))).then_some(now)
    }

    /// Records the frame if it is [no longer to be rendered](Self::state_now). Returns whether this
    /// is so.
    pub(super) fn is_there_now(&self, step: &Step) -> bool {
        let Some((path, state)) = self.state_now(step) else { return false };
        self.settle(step.frame, &path, &state, true);
        true
    }

    pub(super) fn keep(&self, frame: i64, path: &Path, counted: bool) {
        {
            let mut record = self.record();
            record.found += 1;
            record.placed.push(Placed::new(frame, path));
        }
        self.progress.found(frame, path, counted);
        if !self.is_sequence {
            self.note(format_args!("`{}` is finished already", path.display()));
        }
        self.print(path);
    }

    /// Makes the files of a frame that is over, in between or beside rendering.
    ///
    /// # Errors
    /// The user interrupted it.
    pub(super) fn develop(&self, taken: Taken, place: Place) -> Result<(), Problem> {
        let frame = taken.frame;
        match self.studio.develop(taken) {
            Ok(done) => self.finish(frame, done, place),
            Err(problem) if problem.exit == Exit::Stopped && interrupt::requested() => {
                return Err(problem);
            }
            Err(problem) => self.fail(frame, problem, false),
        }
        Ok(())
    }

    /// Records a picture that is in place for good.
    pub(super) fn finish(&self, frame: i64, mut done: Done, place: Place) {
        self.print(&done.path);
        let missing = done.missing.take();
        let is_whole = missing.is_none();
        {
            let mut record = self.record();
            record.placed.push(Placed::new(frame, &done.path));
            if is_whole {
                record.summary.add(&done, place);
            }
        }
        match missing {
            Some(problem) => self.fail(frame, problem, false),
            None => self.progress.finished(frame, &done.path, done.times.total(), done.outcome),
        }
    }

    pub(super) fn fail(&self, frame: i64, problem: Problem, counted: bool) {
        self.progress.failed(frame, &problem, counted);
        if self.is_sequence {
            let message = problem.of_frame(frame);
            let terminal = self.studio.terminal;
            self.progress.suspended(|| terminal.error(message, &problem.help));
        }
        self.record().failures.push((frame, problem));
    }

    /// Prints a picture's path. If that fails, rendering continues.
    pub(super) fn print(&self, path: &Path) {
        let printed = self.progress.suspended(|| print(path.as_os_str().as_encoded_bytes()));
        let mut record = self.record();
        record.unprinted = record.unprinted.take().or(printed.err());
    }

    pub(super) fn warn(&self, text: impl Display) {
        self.progress.suspended(|| self.studio.terminal.warn(text));
    }

    pub(super) fn note(&self, text: impl Display) {
        self.progress.suspended(|| self.studio.terminal.note(text));
    }

    /// Reports to programs how the run went. Its frames took `time`.
    pub(super) fn ended(&self, time: Duration) {
        let Record { summary, found, failures, .. } = &*self.record();
        self.progress.ended(summary.frames, *found, failures.len(), time);
    }

    /// Checks whether all pictures are still in place: others may have replaced or removed some
    /// since.
    pub(super) fn look_once_more(&self) {
        let placed = mem::take(&mut self.record().placed);
        for Placed { frame, path, stamp } in placed {
            if stamp.is_some() && Stamp::of(&path) == stamp {
                continue;
            }
            let why = match self.studio.target.look(frame, &path) {
                Found::Finished => continue,
                Found::Missing => "it is no longer there".into(),
                Found::Damaged => "it has been damaged since".into(),
                Found::Stale(what) => format!("another run has replaced it: {what}"),
                Found::Foreign(what) => format!("another program has replaced it: {what}"),
            };
            let message = format!("`{}` was in place, but {why}", path.display());
            self.fail(frame, Problem::new(Exit::Failed, message), false);
        }
    }

    /// Reports how the run went. Returns an error if frames failed or a path could not be printed.
    pub(super) fn end(self) -> Result<Studio<'a>, Problem> {
        drop(self.progress);
        let record = self.record.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
        let Record { mut summary, found, mut failures, unprinted, .. } = record;
        summary.cache = self.studio.job.cache.as_ref().map(|cache| cache.uses());
        let terminal = self.studio.terminal;
        if summary.frames > 0 {
            summary.tell(self.studio.scene, terminal);
        }
        if self.is_sequence && found > 0 {
            let were = if found == 1 { "was" } else { "were" };
            terminal.note(format_args!("{} {were} finished already", counted(found, "frame")));
        }
        if let Some(why) = self.late {
            terminal.note(why);
        }
        match failures.len() {
            0 => unprinted.map_or(Ok(self.studio), |error| Err(cant_print(&error))),
            1 if !self.is_sequence => Err(failures.remove(0).1),
            _ => {
                let frames: BTreeSet<i64> = failures.iter().map(|failure| failure.0).collect();
                let frames: Vec<i64> = frames.into_iter().collect();
                let all = self.frames;
                let failed = frames.len();
                let message =
                    format!("{failed} of {} failed: {}", counted(all, "frame"), shown(&frames));
                Err(Problem::new(exit_of(&failures, failed == all), message))
            }
        }
    }
}

/// Returns an error if the run was asked to stop.
pub(super) fn may_begin(frame: i64) -> Result<(), Problem> {
    if interrupt::requested() {
        return Err(Problem::new(Exit::Stopped, format!("interrupted before frame {frame}"))
            .with_help("run the same command again to continue"));
    }
    Ok(())
}

fn cant_print(error: &io::Error) -> Problem {
    let message = format!("can't print the paths of the pictures: {error}");
    Problem::new(Exit::Failed, message).with_help("all pictures are in place")
}
