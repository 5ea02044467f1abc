//! Rendering one frame to a file.

use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::checkpoint::Checkpoint;
use super::options::Job;
use super::problem::Problem;
use super::progress::{FrameProgress, Progress};
use super::summary::{Size, Times};
use super::target::Target;
use super::terminal::Terminal;
use super::{Exit, interrupt, load};
use crate::film::{Film, TooLarge};
use crate::output::{Outcome, check_writable};
use crate::render::{Observer, Statistics, render};
use crate::scene::SceneDescription;

/// What rendering any frame of a job looks at.
pub(super) struct Studio<'a> {
    pub(super) job: &'a Job,
    pub(super) scene: &'a SceneDescription,
    pub(super) target: Target<'a>,
    pub(super) terminal: Terminal,
}

/// A frame whose picture is in place.
#[derive(Debug)]
pub(super) struct Done {
    pub(super) path: PathBuf,
    pub(super) times: Times,
    pub(super) statistics: Statistics,
    pub(super) size: Size,
    pub(super) outcome: Outcome,
}

impl Studio<'_> {
    /// Builds, renders and saves a frame; `expected` is where its picture goes.
    pub(super) fn render(
        &self,
        frame: i64,
        expected: &Path,
        progress: &Progress,
    ) -> Result<Done, Problem> {
        find_out_if_writable(expected)?;
        let watch =
            Watch { progress: progress.frame(frame, expected), checkpoint: self.checkpoint(frame) };
        let film = watch.checkpoint.film().map_err(too_large)?;
        let start = Instant::now();
        let built = load::frame(self.job, self.scene, frame)?;
        let building = start.elapsed();
        let start = Instant::now();
        let exposed = render(&built, self.target.plan(), film, &watch);
        let rendering = start.elapsed();
        let checkpoint = watch.checkpoint;
        if !exposed.is_complete {
            return Err(stopped(frame, &checkpoint, exposed.film));
        }
        let start = Instant::now();
        let path = self.target.path(frame, rendering);
        let outcome = self.save(frame, &exposed.film, &path, &checkpoint)?;
        self.target
            .write_maps(frame, &exposed.film)
            .map_err(|(path, error)| cant_write(&path, &error))?;
        if self.job.keep_state {
            checkpoint.keep_finished(exposed.film).map_err(|error| cant_write(&path, &error))?;
        }
        checkpoint.remove();
        let times =
            Times { loading: Duration::ZERO, building, rendering, writing: start.elapsed() };
        let size = Size::of(&built);
        Ok(Done { path, times, statistics: exposed.statistics, size, outcome })
    }

    fn checkpoint(&self, frame: i64) -> Checkpoint {
        let (path, subject) = (self.target.plain_path(frame), self.target.subject(frame));
        Checkpoint::new(&path, subject, self.job.checkpoint, self.terminal)
    }

    /// Saves the picture; where that fails, what is known of it.
    fn save(
        &self,
        frame: i64,
        film: &Film,
        path: &Path,
        checkpoint: &Checkpoint,
    ) -> Result<Outcome, Problem> {
        let written = self.target.write(frame, film, path).map_err(|error| {
            let problem = cant_write(path, &error);
            match checkpoint.save(film.clone(), true) {
                Ok(()) => problem.with_help("its samples are kept: run the same command again"),
                Err(_) => problem,
            }
        })?;
        if written.not_finite > 0 {
            let black = written.not_finite;
            self.terminal.warn(format_args!("{black} pixels are no numbers and were left black"));
        }
        Ok(written.outcome)
    }
}

/// Watches a frame for the progress and the checkpoint.
struct Watch<'a> {
    progress: FrameProgress<'a>,
    checkpoint: Checkpoint,
}

impl Observer for Watch<'_> {
    fn advanced(&self, share: f64) {
        self.progress.advanced(share);
    }

    fn resumed(&self, share: f64) {
        self.progress.resumed(share);
    }

    fn should_stop(&self) -> bool {
        interrupt::requested()
    }

    fn wants_film(&self) -> bool {
        self.checkpoint.is_due()
    }

    fn keep(&self, film: Film) {
        self.checkpoint.keep(film);
    }
}

fn stopped(frame: i64, checkpoint: &Checkpoint, film: Film) -> Problem {
    match checkpoint.save(film, false) {
        Ok(()) => Problem::new(Exit::Stopped, format!("interrupted in frame {frame}"))
            .with_help("what is done of it is kept: the same command goes on from there"),
        Err(error) => {
            let message = format!("interrupted in frame {frame}, which can't be kept: {error}");
            Problem::new(Exit::Stopped, message)
        }
    }
}

fn cant_write(path: &Path, error: &io::Error) -> Problem {
    Problem::new(Exit::CantWrite, format!("can't write `{}`: {error}", path.display()))
}

fn find_out_if_writable(path: &Path) -> Result<(), Problem> {
    check_writable(path).map_err(|error| {
        Problem::new(Exit::CantCreate, format!("can't create `{}`: {error}", path.display()))
            .with_help("`--outdir` names another folder")
    })
}

fn too_large(TooLarge { bytes }: TooLarge) -> Problem {
    let message = format!("the picture needs {:.1} GB of memory", bytes as f64 / 1e9);
    Problem::new(Exit::Failed, message).with_help("`--size` makes it smaller")
}
