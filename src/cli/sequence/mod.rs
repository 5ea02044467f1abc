//! Rendering the frames of a job, one after the other, in one process.

mod claims;
mod dry_run;
mod frames;
mod ledger;
mod order;
mod plan;
mod schedule;
mod shared;
mod total;

use std::collections::HashSet;
use std::fmt::Display;
use std::io;
use std::mem;
use std::path::{Path, PathBuf};
use std::time::{Instant, SystemTime};

use super::interrupt::Guard;
use super::options::Job;
use super::problem::Problem;
use super::progress::Progress;
use super::render::{Done, Studio};
use super::room::Needs;
use super::summary::Summary;
use super::target::{Target, not_ours};
use super::terminal::{Terminal, print};
use super::{Exit, interrupt, load};
use crate::accel::Accelerator;
use crate::frame::FrameScene;
use crate::output::Found;
use crate::scene::SceneDescription;
use claims::Left;
pub(super) use frames::{Frames, shown};
pub(super) use order::Order;
use plan::{State, Step};

/// Renders the job's frames, prints the paths of their pictures, and says how it went.
pub(super) fn run(job: &Job, terminal: Terminal) -> Result<(), Problem> {
    let start = Instant::now();
    // What would be rendered can be found out again.
    let _guard = (!job.dry_run).then(Guard::new);
    let threads = load::threads(job.threads)?;
    let scene = threads.install(|| load::scene(job, terminal))?;
    let go = || render(job, &scene, terminal, start);
    match (job.threads, scene.settings.parallel_threads) {
        (None, Some(asked)) => load::threads(Some(asked as usize))?.install(go),
        _ => threads.install(go),
    }
}

fn render(
    job: &Job,
    scene: &SceneDescription,
    terminal: Terminal,
    begin: Instant,
) -> Result<(), Problem> {
    let loading = begin.elapsed();
    let target = Target::new(job, scene)?;
    let steps = plan::steps(job, scene, &target);
    if job.dry_run {
        return dry_run::tell(&steps, terminal);
    }
    if let Some(first) = steps.iter().find(|step| step.is_to_render()) {
        let subject = target.subject(first.frame);
        let format = scene.camera.film.output;
        let frames = to_render(&steps);
        let needs = Needs::of(&subject, format, frames, job.beside());
        let needs = if job.total_time.is_some() { needs.with_states(frames) } else { needs };
        needs.check(&job.outdir, terminal)?;
        warn_of_structure(scene.settings.accelerator, terminal);
    }
    let pictures = steps.iter().filter(|step| step.is_to_render());
    job.maps.check(pictures.map(|step| (step.frame, &*step.path)))?;
    let studio = Studio { job, scene, target, terminal };
    let mut run = Run {
        studio,
        frames: steps.len(),
        is_sequence: steps.len() > 1,
        progress: Progress::new(
            job.progress,
            job.share.is_some(),
            steps.len(),
            to_render(&steps),
            terminal,
        ),
        summary: Summary::new(loading, job.isa),
        found: 0,
        before: None,
        failures: Vec::new(),
        placed: Vec::new(),
        late: None,
        unprinted: None,
    };
    let claimed: Vec<_> =
        steps.iter().map(|step| run.studio.target.plain_path(step.frame)).collect();
    let left = Left::look(&job.outdir, claimed.iter().map(|path| &**path));
    Guard::begin_work();
    let start = Instant::now();
    let result = match (job.share, job.total_time) {
        (Some(lease), _) => run.share(steps, lease),
        (None, Some(span)) => run.rounds(steps, span, begin),
        (None, None) => steps.iter().try_for_each(|step| run.step(step)),
    };
    let result = result.map(|()| run.look_once_more());
    let time = start.elapsed();
    run.progress.ended(run.summary.frames, run.found, run.failures.len(), time);
    result?;
    run.end()?;
    left.sweep();
    Ok(())
}

fn to_render(steps: &[Step]) -> usize {
    steps.iter().filter(|step| step.is_to_render()).count()
}

/// A picture that was in place.
struct Placed {
    frame: i64,
    path: PathBuf,
    stamp: Option<Stamp>,
}

/// What tells a file from another one under its name, without reading either.
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

/// A run under way.
struct Run<'a> {
    studio: Studio<'a>,
    /// All that were asked for.
    frames: usize,
    is_sequence: bool,
    progress: Progress,
    summary: Summary,
    /// Frames that were there already.
    found: usize,
    failures: Vec<(i64, Problem)>,
    /// Pictures that are in place.
    placed: Vec<Placed>,
    /// Why the run took longer than its time.
    late: Option<String>,
    /// Why a path could not be printed.
    unprinted: Option<io::Error>,
    /// What was built for the last frame.
    before: Option<FrameScene>,
}

impl Run<'_> {
    /// Does what is to do for one frame. An error ends the run.
    fn step(&mut self, step: &Step) -> Result<(), Problem> {
        match &step.state {
            State::Finished => self.keep(step.frame, &step.path, false),
            State::None(error) => self.fail(step.frame, load::no_segment(error), false),
            State::Foreign(why) => self.fail(step.frame, not_ours(&step.path, why), false),
            State::ToRender(_) if self.is_there_now(step) => {}
            State::ToRender(_) => drop(self.render(step.frame, &step.path, &|| false)?),
        }
        Ok(())
    }

    /// Whether another process has finished the frame since, or somebody has put another file in its place.
    fn is_there_now(&mut self, step: &Step) -> bool {
        let (path, state) = plan::look_again(self.studio.job, &self.studio.target, step.frame);
        match state {
            State::Finished => self.keep(step.frame, &path, true),
            State::Foreign(why) => self.fail(step.frame, not_ours(&path, &why), true),
            State::ToRender(_) | State::None(_) => return false,
        }
        true
    }

    fn keep(&mut self, frame: i64, path: &Path, counted: bool) {
        self.found += 1;
        self.placed.push(Placed::new(frame, path));
        self.progress.found(frame, path, counted);
        if !self.is_sequence {
            self.note(format_args!("`{}` is there already", path.display()));
        }
        self.print(path);
    }

    /// Renders a frame, as long as it is this process's; false where it is not any more.
    fn render(
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

    /// A picture is in place, for good.
    fn finish(&mut self, frame: i64, mut done: Done) {
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

    fn fail(&mut self, frame: i64, problem: Problem, counted: bool) {
        self.progress.failed(frame, &problem, counted);
        if self.is_sequence {
            let message = problem.of_frame(frame);
            let terminal = self.studio.terminal;
            self.progress.suspended(|| terminal.error(message, &problem.help));
        }
        self.failures.push((frame, problem));
    }

    /// Prints a picture's path. Pictures are rendered also where nobody can be told.
    fn print(&mut self, path: &Path) {
        let printed = self.progress.suspended(|| print(path.as_os_str().as_encoded_bytes()));
        self.unprinted = self.unprinted.take().or(printed.err());
    }

    fn warn(&self, text: impl Display) {
        self.progress.suspended(|| self.studio.terminal.warn(text));
    }

    fn note(&self, text: impl Display) {
        self.progress.suspended(|| self.studio.terminal.note(text));
    }

    /// Whether all pictures are still in place: others may have replaced or removed some since.
    fn look_once_more(&mut self) {
        for Placed { frame, path, stamp } in mem::take(&mut self.placed) {
            if stamp.is_some() && Stamp::of(&path) == stamp {
                continue;
            }
            let why = match self.studio.target.look(frame, &path) {
                Found::Finished => continue,
                Found::Missing => "it is not there any more".into(),
                Found::Damaged => "it was damaged since".into(),
                Found::Stale(what) => format!("another run has replaced it: {what}"),
                Found::Foreign(what) => format!("another program has replaced it: {what}"),
            };
            let message = format!("`{}` was in place, but {why}", path.display());
            self.fail(frame, Problem::new(Exit::Failed, message), false);
        }
    }

    /// Says how the run went; an error where frames failed.
    fn end(mut self) -> Result<(), Problem> {
        drop(self.progress);
        let terminal = self.studio.terminal;
        if self.summary.frames > 0 {
            self.summary.tell(self.studio.scene, terminal);
        }
        if self.is_sequence && self.found > 0 {
            let frames = if self.found == 1 { "frame was" } else { "frames were" };
            terminal.note(format_args!("{} {frames} there already", self.found));
        }
        if let Some(why) = self.late {
            terminal.note(why);
        }
        match self.failures.len() {
            0 => self.unprinted.map_or(Ok(()), |error| Err(cant_print(&error))),
            1 if !self.is_sequence => Err(self.failures.remove(0).1),
            _ => {
                let frames: HashSet<i64> = self.failures.iter().map(|failure| failure.0).collect();
                let frames: Vec<i64> = frames.into_iter().collect();
                let all = self.frames;
                let failed = frames.len();
                let message = format!("{failed} of {all} frames failed: {}", shown(&frames));
                Err(Problem::new(exit(&self.failures, failed == all), message))
            }
        }
    }
}

/// One structure is there to be measured against.
fn warn_of_structure(accelerator: Accelerator, terminal: Terminal) {
    if accelerator == Accelerator::Cwbvh {
        terminal.warn("CWBVH is for measuring: it may miss hits at edges, and the picture differ");
    }
}

/// An error where the run was asked to stop.
fn may_begin(frame: i64) -> Result<(), Problem> {
    if interrupt::requested() {
        return Err(Problem::new(Exit::Stopped, format!("interrupted before frame {frame}"))
            .with_help("the same command goes on from there"));
    }
    Ok(())
}

fn cant_print(error: &io::Error) -> Problem {
    let message = format!("can't print the paths of the pictures: {error}");
    Problem::new(Exit::Failed, message).with_help("the pictures are all there")
}

/// Where all frames failed alike there is nothing partial about it.
fn exit(failures: &[(i64, Problem)], all: bool) -> Exit {
    let first = failures[0].1.exit;
    let alike = failures.iter().all(|(_, problem)| problem.exit == first);
    if all && alike { first } else { Exit::Failed }
}
