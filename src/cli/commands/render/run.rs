//! A run in progress: what it does for each frame, and its overall result.

use std::collections::BTreeSet;
use std::fmt::Display;
use std::io;
use std::mem;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use super::done::{Done, exit_of};
use super::frame::Studio;
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

/// A run in progress.
pub(super) struct Run<'a> {
    pub(super) studio: Studio<'a>,
    /// Number of frames that were asked for.
    frames: usize,
    is_sequence: bool,
    pub(super) progress: Progress,
    summary: Summary,
    /// Number of frames that were finished already.
    pub(super) found: usize,
    pub(super) failures: Vec<(i64, Problem)>,
    /// Pictures that are in place.
    placed: Vec<Placed>,
    /// Why the run took longer than its time.
    pub(super) late: Option<String>,
    /// Why a path could not be printed.
    unprinted: Option<io::Error>,
    /// What was built for the last frame.
    pub(super) before: Option<FrameScene>,
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
        Self {
            studio,
            frames,
            is_sequence: frames > 1,
            progress,
            summary: Summary::new(loading, job.isa),
            found: 0,
            before: None,
            failures: Vec::new(),
            placed: Vec::new(),
            late: None,
            unprinted: None,
        }
    }

    /// Does what one frame needs. An error ends the run.
    pub(super) fn step(&mut self, step: &Step) -> Result<(), Problem> {
        match &step.state {
            State::Finished => self.keep(step.frame, &step.path, false),
            State::None(error) => self.fail(step.frame, load::no_segment(error), false),
            State::Foreign(why) => self.fail(step.frame, not_ours(&step.path, why), false),
            State::ToRender(_) if self.is_there_now(step) => {}
            State::ToRender(_) => drop(self.render(step.frame, &step.path, &|| false)?),
        }
        Ok(())
    }

    /// Records the frame if another process has finished it since, or if somebody has put another
    /// file in its place. Returns whether this is so.
    pub(super) fn is_there_now(&mut self, step: &Step) -> bool {
        let (path, state) = plan::look_again(self.studio.job, &self.studio.target, step.frame);
        match state {
            State::Finished => self.keep(step.frame, &path, true),
            State::Foreign(why) => self.fail(step.frame, not_ours(&path, &why), true),
            State::ToRender(_) | State::None(_) => return false,
        }
        true
    }

    pub(super) fn keep(&mut self, frame: i64, path: &Path, counted: bool) {
        self.found += 1;
        self.placed.push(Placed::new(frame, path));
        self.progress.found(frame, path, counted);
        if !self.is_sequence {
            self.note(format_args!("`{}` is finished already", path.display()));
        }
        self.print(path);
    }

    /// Renders a frame as long as it belongs to this process. Returns false if it no longer does.
    pub(super) fn render(
        &mut self,
        frame: i64,
        path: &Path,
        is_lost: &(dyn Fn() -> bool + Sync),
    ) -> Result<bool, Problem> {
        may_begin(frame)?;
        let (studio, before) = (&self.studio, &mut self.before);
        match studio.render(frame, path, studio.limit(), &self.progress, before, is_lost) {
            Ok(done) => self.finish(frame, done),
            Err(problem) if problem.exit == Exit::Stopped && interrupt::requested() => {
                return Err(problem);
            }
            Err(problem) if problem.exit == Exit::Stopped => return Ok(false),
            Err(problem) => self.fail(frame, problem, true),
        }
        Ok(true)
    }

    /// Records a picture that is in place for good.
    pub(super) fn finish(&mut self, frame: i64, mut done: Done) {
        self.print(&done.path);
        self.placed.push(Placed::new(frame, &done.path));
        match done.missing.take() {
            Some(problem) => self.fail(frame, problem, true),
            None => {
                self.summary.add(&done);
                self.progress.finished(frame, &done.path, done.times.total(), done.outcome);
            }
        }
    }

    pub(super) fn fail(&mut self, frame: i64, problem: Problem, counted: bool) {
        self.progress.failed(frame, &problem, counted);
        if self.is_sequence {
            let message = problem.of_frame(frame);
            let terminal = self.studio.terminal;
            self.progress.suspended(|| terminal.error(message, &problem.help));
        }
        self.failures.push((frame, problem));
    }

    /// Prints a picture's path. If that fails, rendering continues.
    pub(super) fn print(&mut self, path: &Path) {
        let printed = self.progress.suspended(|| print(path.as_os_str().as_encoded_bytes()));
        self.unprinted = self.unprinted.take().or(printed.err());
    }

    pub(super) fn warn(&self, text: impl Display) {
        self.progress.suspended(|| self.studio.terminal.warn(text));
    }

    pub(super) fn note(&self, text: impl Display) {
        self.progress.suspended(|| self.studio.terminal.note(text));
    }

    /// Reports to programs how the run went. Its frames took `time`.
    pub(super) fn ended(&self, time: Duration) {
        self.progress.ended(self.summary.frames, self.found, self.failures.len(), time);
    }

    /// Checks whether all pictures are still in place: others may have replaced or removed some
    /// since.
    pub(super) fn look_once_more(&mut self) {
        for Placed { frame, path, stamp } in mem::take(&mut self.placed) {
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
    pub(super) fn end(mut self) -> Result<(), Problem> {
        drop(self.progress);
        let terminal = self.studio.terminal;
        if self.summary.frames > 0 {
            self.summary.tell(self.studio.scene, terminal);
        }
        if self.is_sequence && self.found > 0 {
            let were = if self.found == 1 { "was" } else { "were" };
            terminal.note(format_args!("{} {were} finished already", counted(self.found, "frame")));
        }
        if let Some(why) = self.late {
            terminal.note(why);
        }
        match self.failures.len() {
            0 => self.unprinted.map_or(Ok(()), |error| Err(cant_print(&error))),
            1 if !self.is_sequence => Err(self.failures.remove(0).1),
            _ => {
                let frames: BTreeSet<i64> = self.failures.iter().map(|failure| failure.0).collect();
                let frames: Vec<i64> = frames.into_iter().collect();
                let all = self.frames;
                let failed = frames.len();
                let message =
                    format!("{failed} of {} failed: {}", counted(all, "frame"), shown(&frames));
                Err(Problem::new(exit_of(&self.failures, failed == all), message))
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
