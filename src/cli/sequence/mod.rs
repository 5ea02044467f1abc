//! Rendering the frames of a job, one after the other, in one process.

mod dry_run;
mod frames;
mod order;
mod plan;

use std::path::Path;
use std::time::{Duration, Instant};

use super::interrupt::Guard;
use super::options::Job;
use super::problem::Problem;
use super::progress::Progress;
use super::render::Studio;
use super::room::Needs;
use super::summary::Summary;
use super::target::Target;
use super::terminal::{Terminal, print};
use super::{Exit, interrupt, load};
use crate::frame::FrameScene;
use crate::scene::SceneDescription;
pub(super) use frames::{Frames, shown};
pub(super) use order::Order;
use plan::{State, Step};

/// Renders the job's frames, prints the paths of their pictures, and says how it went.
pub(super) fn run(job: &Job, terminal: Terminal) -> Result<(), Problem> {
    let start = Instant::now();
    let _guard = Guard::new();
    let threads = load::threads(job.threads)?;
    let scene = threads.install(|| load::scene(job, terminal))?;
    let loading = start.elapsed();
    let go = || render(job, &scene, terminal, loading);
    match (job.threads, scene.settings.parallel_threads) {
        (None, Some(asked)) => load::threads(Some(asked as usize))?.install(go),
        _ => threads.install(go),
    }
}

fn render(
    job: &Job,
    scene: &SceneDescription,
    terminal: Terminal,
    loading: Duration,
) -> Result<(), Problem> {
    let target = Target::new(job, scene)?;
    let steps = plan::steps(job, scene, &target);
    if job.dry_run {
        return dry_run::tell(&steps, terminal);
    }
    if let Some(first) = steps.iter().find(|step| step.is_to_render()) {
        let subject = target.subject(first.frame);
        let format = scene.camera.film.output;
        Needs::of(&subject, format, to_render(&steps)).check(&job.outdir, terminal);
    }
    let studio = Studio { job, scene, target, terminal };
    let mut run = Run {
        studio,
        is_sequence: steps.len() > 1,
        progress: Progress::new(job.progress, steps.len(), to_render(&steps), terminal),
        summary: Summary::new(loading, job.isa),
        found: 0,
        before: None,
        failures: Vec::new(),
    };
    let start = Instant::now();
    let result = steps.into_iter().try_for_each(|step| run.step(step));
    let time = start.elapsed();
    run.progress.ended(run.summary.frames, run.found, run.failures.len(), time);
    result?;
    run.end()
}

fn to_render(steps: &[Step]) -> usize {
    steps.iter().filter(|step| step.is_to_render()).count()
}

/// A run under way.
struct Run<'a> {
    studio: Studio<'a>,
    is_sequence: bool,
    progress: Progress,
    summary: Summary,
    /// Frames that were there already.
    found: usize,
    failures: Vec<(i64, Problem)>,
    /// What was built for the last frame.
    before: Option<FrameScene>,
}

impl Run<'_> {
    /// Does what is to do for one frame. An error ends the run.
    fn step(&mut self, step: Step) -> Result<(), Problem> {
        let (job, target) = (self.studio.job, &self.studio.target);
        match step.state {
            State::Finished => self.keep(step.frame, &step.path, false),
            State::None(error) => {
                let problem = load::no_segment(&error);
                self.fail(step.frame, problem, false);
                Ok(())
            }
            // Another process may have been here since.
            State::ToRender(_) => match plan::look(job, target, step.frame, &step.path) {
                State::Finished => self.keep(step.frame, &step.path, true),
                _ => self.render(step.frame, &step.path),
            },
        }
    }

    fn keep(&mut self, frame: i64, path: &Path, counted: bool) -> Result<(), Problem> {
        self.found += 1;
        self.progress.found(frame, path, counted);
        if !self.is_sequence {
            let path = path.display();
            self.studio.terminal.note(format_args!("`{path}` is there already"));
        }
        self.print(path)
    }

    fn render(&mut self, frame: i64, path: &Path) -> Result<(), Problem> {
        if interrupt::requested() {
            return Err(Problem::new(Exit::Stopped, format!("interrupted before frame {frame}"))
                .with_help("the same command goes on from there"));
        }
        match self.studio.render(frame, path, &self.progress, &mut self.before) {
            Ok(done) => {
                self.summary.add(&done);
                let time = done.times.total();
                self.progress.finished(frame, &done.path, time, done.outcome);
                self.print(&done.path)
            }
            Err(problem) if problem.exit == Exit::Stopped => Err(problem),
            Err(problem) => {
                self.fail(frame, problem, true);
                Ok(())
            }
        }
    }

    fn fail(&mut self, frame: i64, problem: Problem, counted: bool) {
        self.progress.failed(frame, &problem, counted);
        if self.is_sequence {
            let message = format!("frame {frame}: {}", problem.message);
            let terminal = self.studio.terminal;
            self.progress.suspended(|| terminal.error(message, &problem.help));
        }
        self.failures.push((frame, problem));
    }

    fn print(&self, path: &Path) -> Result<(), Problem> {
        let printed = self.progress.suspended(|| print(path.as_os_str().as_encoded_bytes()));
        printed.map_err(|error| {
            Problem::new(Exit::Failed, format!("can't print the picture's path: {error}"))
        })
    }

    /// Says how the run went; an error where frames failed.
    fn end(mut self) -> Result<(), Problem> {
        drop(self.progress);
        let terminal = self.studio.terminal;
        if self.summary.frames > 0 {
            self.summary.tell(self.studio.scene, terminal);
        }
        if self.is_sequence && self.found > 0 {
            terminal.note(format_args!("{} frames were there already", self.found));
        }
        match self.failures.len() {
            0 => Ok(()),
            1 if !self.is_sequence => Err(self.failures.remove(0).1),
            failed => {
                let frames: Vec<i64> = self.failures.iter().map(|failure| failure.0).collect();
                let all = self.summary.frames + self.found + failed;
                let message = format!("{failed} of {all} frames failed: {}", shown(&frames));
                Err(Problem::new(exit(&self.failures, failed == all), message))
            }
        }
    }
}

/// Where all frames failed alike there is nothing partial about it.
fn exit(failures: &[(i64, Problem)], all: bool) -> Exit {
    let first = failures[0].1.exit;
    let alike = failures.iter().all(|(_, problem)| problem.exit == first);
    if all && alike { first } else { Exit::Failed }
}
