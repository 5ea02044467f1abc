//! Renders one frame to a file.

use std::fs;
use std::io;
use std::path::Path;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use super::counted::{self, Counted};
use super::desk::Desk;
use super::done::{Done, Size, Times};
use super::guide_file::GuideFile;
use super::target::{Target, in_the_way};
use super::watch::Watcher;
use crate::cli::base::{Exit, Problem, Terminal, counted};
use crate::cli::files::checkpoint::{Checkpoint, recipe_hash, states_in, unfinished};
use crate::cli::options::Job;
use crate::cli::progress::{FrameProgress, Progress};
use crate::cli::system::display::{Display, DisplayedImage};
use crate::cli::system::memory::Reserve;
use crate::cli::system::room::{Beside, Needs};
use crate::cli::system::{interrupt, patience};
use slo_picture::film::Steps;
use slo_picture::film::{Film, TooLarge};
use slo_picture::output::{Outcome, check_free, check_writable, remove_leftovers, sweep_abandoned};
use slo_render::frame::FrameScene;
use slo_render::guiding::Field;
use slo_render::render::{Budget, Exposed, Observer, Statistics, render, render_until};
use slo_scene::{Layer, SceneDescription};

/// Approximate time to encode and write a pixel, in nanoseconds.
const WRITING_PER_PIXEL: u64 = 150;

/// Everything that rendering a frame of a job needs.
pub(super) struct Studio<'a> {
    pub(super) job: &'a Job,
    pub(super) scene: &'a SceneDescription,
    pub(super) target: Target<'a>,
    pub(super) terminal: Terminal,
    /// The viewer that shows pictures while they are rendered.
    pub(super) display: Option<Display>,
    /// Looks at the files of the scene: if one changes, the frame is not worth finishing.
    pub(super) watcher: Option<&'a Watcher>,
}

/// Limit after which a frame takes no more samples, by the clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Limit {
    /// Time since the beginning of the frame's building.
    pub(super) time: Duration,
    /// Last step that the frame takes.
    pub(super) step: u32,
}

/// A frame that has all of its samples.
pub(super) struct Taken {
    pub(super) frame: i64,
    film: Film,
    /// How far the frame was taken, if the clock decided it.
    steps: Option<Steps>,
    checkpoint: Checkpoint,
    /// Memory for the files.
    end: Reserve,
    pub(super) times: Times,
    statistics: Statistics,
    size: Size,
    counted: Option<Counted>,
}

impl Studio<'_> {
    /// Builds, renders and saves a frame. `expected` is the path of its picture. `before` holds
    /// what was built for another frame, and afterwards what was built for this one. If `is_lost`,
    /// the frame belongs to another process, and rendering stops without keeping anything.
    ///
    /// If all frames share a time, the state of this frame stays until the frame is
    /// [closed](Self::close).
    pub(super) fn render(
        &self,
        frame: i64,
        expected: &Path,
        limit: Option<Limit>,
        progress: &Progress,
        before: &mut Option<FrameScene>,
        is_lost: &(dyn Fn() -> bool + Sync),
    ) -> Result<Done, Problem> {
        let mut desk = Desk::new(before.take(), None);
        let taken = self.take(frame, expected, limit, progress, &mut desk, is_lost);
        *before = desk.before;
        self.develop(taken?)
    }

    /// Builds and renders a frame. The rest is its [development](Self::develop).
    pub(super) fn take(
        &self,
        frame: i64,
        expected: &Path,
        limit: Option<Limit>,
        progress: &Progress,
        desk: &mut Desk<'_>,
        is_lost: &(dyn Fn() -> bool + Sync),
    ) -> Result<Taken, Problem> {
        find_out_if_writable(expected, desk.before.is_none())?;
        let (progress, checkpoint) = (progress.frame(frame, expected), self.checkpoint(frame));
        let guide_file = GuideFile::new(self.job, self.scene, frame, self.terminal);
        let display = self.display.as_ref().map(|display| {
            let film = &self.scene.camera.film;
            display.image(&expected.to_string_lossy(), film.width, film.height)
        });
        let photons = Mutex::default();
        let watch = Watch { progress, checkpoint, guide_file, display, photons, is_lost };
        let start = Instant::now();
        let built = desk.frame(self.job, self.scene, frame)?;
        let built = match watch.guide_file.read()? {
            Some(field) if built.is_guided() => built.with_field(field),
            _ => built,
        };
        let mut built = built;
        counted::begin(self.job, &mut built)?;
        let ((film, least), end) = match self.film(frame, &watch.checkpoint) {
            // The picture before this one takes memory until it is in place.
            Err(_) if desk.is_writing() => {
                desk.written()?;
                self.film(frame, &watch.checkpoint)?
            }
            film => film?,
        };
        desk.begin_next(&built);
        let budget =
            limit.map(|Limit { time, step }| Budget { deadline: start + time, least, last: step });
        let building = start.elapsed();
        let start = Instant::now();
        let size = Size::of(&built);
        let (exposed, steps) = self.expose(&built, film, budget, &watch);
        let all = start.elapsed();
        let Watch { checkpoint, photons, .. } = watch;
        let photons = photons.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
        let rendering = all.saturating_sub(photons);
        let Exposed { film, statistics, is_complete } = exposed;
        let times = Times { building, photons, rendering, ..Times::default() };
        let counted = Counted::of(self.job, self.scene, frame, &built, &statistics, &times);
        desk.before = Some(built);
        if !is_complete && self.is_stale() && !interrupt::requested() {
            checkpoint.remove();
        }
        if !is_complete && is_lost() {
            return Err(Problem::told(Exit::Stopped));
        }
        if !is_complete {
            return Err(stopped(frame, &checkpoint, film, steps.unwrap_or_default()));
        }
        Ok(Taken { frame, film, steps, checkpoint, end, times, statistics, size, counted })
    }

    /// Whether the files of the scene have changed, so that frames must be rendered again.
    pub(super) fn is_stale(&self) -> bool {
        self.watcher.is_some_and(Watcher::have_changed)
    }

    /// Makes the files of a frame that has all of its samples.
    pub(super) fn develop(&self, taken: Taken) -> Result<Done, Problem> {
        let Taken { frame, film, steps, checkpoint, end, times, statistics, size, counted } = taken;
        let start = Instant::now();
        end.release();
        let path = self.target.path(frame, times.photons + times.rendering);
        let full_pixels = film.full_pixels();
        let (outcome, beside) =
            self.put_in_place(frame, film, steps, &path, &checkpoint, counted)?;
        let times = Times { writing: start.elapsed(), ..times };
        let missing = beside.err();
        Ok(Done { path, times, statistics, size, full_pixels, outcome, missing, steps })
    }

    /// Returns the film of a frame, the steps to which it must be continued, and the reserve for the
    /// end of the frame.
    fn film(
        &self,
        frame: i64,
        checkpoint: &Checkpoint,
    ) -> Result<((Film, Steps), Reserve), Problem> {
        let needs = self.needs(frame, 1);
        let film = checkpoint.film().map_err(|TooLarge { .. }| needs.too_large())?;
        Ok((film, self.reserve(&needs)?))
    }

    /// Writes the files that are made from a film, and the film itself if it is still needed. Also
    /// returns whether the files beside the picture could be written.
    fn put_in_place(
        &self,
        frame: i64,
        mut film: Film,
        steps: Option<Steps>,
        path: &Path,
        checkpoint: &Checkpoint,
        counted: Option<Counted>,
    ) -> Result<(Outcome, Result<(), Problem>), Problem> {
        let reached = steps.unwrap_or_default();
        let is_open = self.job.total_time.is_some();
        if is_open {
            // The state is written before the picture, because a picture without a state counts as
            // finished.
            checkpoint
                .save_patiently(&mut film, reached)
                .map_err(|error| cant_write(checkpoint.unfinished(), &error))?;
        }
        let outcome = self.save(frame, &mut film, steps, path, checkpoint)?;
        let maps = self.target.write_maps(frame, &film, counted.as_ref(), self.terminal);
        let mut beside = maps.map_err(|(path, error)| cant_write(&path, &error));
        if self.job.keep_state && !is_open {
            let forced = self.job.overwrites();
            let kept = checkpoint.keep_finished(&mut film, reached, forced);
            beside = beside.and(kept.map_err(|error| cant_write(checkpoint.kept(), &error)));
        }
        // If the film could not be kept, its checkpoint stays.
        if !is_open && beside.is_ok() {
            checkpoint.remove();
        }
        Ok((outcome, beside))
    }

    /// Returns what `pictures` pictures like the picture of a frame need.
    pub(super) fn needs(&self, frame: i64, pictures: usize) -> Needs {
        let (subject, format) = (self.target.subject(frame), self.scene.camera.film.output);
        let layers = &self.scene.camera.film.layers;
        let of_pixels =
            layers.iter().filter(|layer| matches!(layer, Layer::Samples | Layer::Error));
        let film = &self.scene.camera.film;
        let pixels = u64::from(film.width) * u64::from(film.height);
        let beside = Beside {
            maps: !self.job.maps.is_empty(),
            states: self.job.keep_state,
            images: of_pixels.count() as u64,
            counted_pixels: self.job.maps.cost.as_ref().map_or(0, |_| pixels),
        };
        Needs::of(&subject, format, pictures, beside)
    }

    /// Makes sure that there is memory for the rest of a frame whose film is allocated. Returns
    /// the reserve for the end of the frame, which must be released then.
    fn reserve(&self, needs: &Needs) -> Result<Reserve, Problem> {
        let too_large = || needs.too_large();
        let work = Reserve::new(needs.work()).ok_or_else(too_large)?;
        let end = Reserve::new(needs.end).ok_or_else(too_large)?;
        work.release();
        Ok(end)
    }

    /// Exposes a film to the end of the plan or of the budget. With a budget, also returns how far
    /// it got.
    fn expose(
        &self,
        frame: &FrameScene,
        film: Film,
        budget: Option<Budget>,
        watch: &Watch,
    ) -> (Exposed, Option<Steps>) {
        let plan = self.target.plan();
        match budget {
            None => (render(frame, plan, film, watch), None),
            Some(budget) => {
                let (exposed, steps) = render_until(frame, plan, film, watch, budget);
                (exposed, Some(steps))
            }
        }
    }

    /// Closes a frame that shares a time with all frames and takes no more samples in this run.
    /// Removes the state of the frame, or keeps it for later runs.
    pub(super) fn close(&self, frame: i64) -> Result<(), Problem> {
        let checkpoint = self.checkpoint(frame);
        if !self.job.keep_state {
            checkpoint.remove();
            return Ok(());
        }
        checkpoint.keep_unfinished().map_err(|error| cant_write(checkpoint.kept(), &error))
    }

    /// Removes the files of a frame that another run left behind when it was killed while writing.
    /// `path` is the path of the frame's picture.
    pub(super) fn clean_up(&self, frame: i64, path: &Path) {
        remove_leftovers(path);
        self.checkpoint(frame).remove_leftovers();
    }

    /// Removes the state of a finished frame.
    pub(super) fn remove_checkpoint(&self, frame: i64) {
        self.checkpoint(frame).remove();
    }

    /// Removes what unfinished runs of these frames have left, which are all finished: states, and
    /// the temporary files of writers that were killed when others had finished the frame.
    pub(super) fn sweep(&self, frames: &[i64]) {
        self.sweep_checkpoints(frames);
        let written = frames.iter().flat_map(|&frame| {
            let path = self.target.plain_path(frame);
            let state = unfinished(&path, &self.target.subject(frame), self.job.is_timed());
            [path, state]
        });
        sweep_abandoned(&self.job.outdir, written);
    }

    /// Removes the states of unfinished runs of these frames: another process has finished what such
    /// a run began, or it was killed between writing the picture and removing the state.
    fn sweep_checkpoints(&self, frames: &[i64]) {
        let left = states_in(&self.job.outdir);
        if left.is_empty() {
            return;
        }
        for &frame in frames {
            let path = self.target.plain_path(frame);
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let beginning = format!(".slo-rt-{name}.");
            if left.iter().any(|name| name.starts_with(&beginning)) {
                let of_frame = unfinished(&path, &self.target.subject(frame), self.job.is_timed());
                let _ = fs::remove_file(of_frame);
            }
        }
    }

    /// Returns a hash of what a frame is rendered from.
    pub(super) fn recipe_hash(&self, frame: i64) -> String {
        recipe_hash(&self.target.subject(frame), self.job.is_timed())
    }

    fn checkpoint(&self, frame: i64) -> Checkpoint {
        let (path, subject) = (self.target.plain_path(frame), self.target.subject(frame));
        let is_timed = self.job.is_timed();
        Checkpoint::new(&path, subject, is_timed, self.job.checkpoint, self.terminal)
    }

    /// Returns the limit of a frame that has a time of its own. The limit leaves time for writing,
    /// so that the picture is in place in time.
    pub(super) fn limit(&self) -> Option<Limit> {
        let film = &self.scene.camera.film;
        let pixels = u64::from(film.width) * u64::from(film.height);
        let writing = Duration::from_nanos(WRITING_PER_PIXEL.saturating_mul(pixels));
        let time = self.job.time?.saturating_sub(writing);
        Some(Limit { time, step: Steps::LAST })
    }

    /// Saves the picture, or its state if that fails.
    fn save(
        &self,
        frame: i64,
        film: &mut Film,
        steps: Option<Steps>,
        path: &Path,
        checkpoint: &Checkpoint,
    ) -> Result<Outcome, Problem> {
        let write = || self.target.write(frame, film, steps, path);
        let written = patience::write(path, self.terminal, write).map_err(|error| {
            let problem = match error.kind() {
                io::ErrorKind::AlreadyExists => in_the_way(path, &error),
                _ => cant_write(path, &error),
            };
            match checkpoint.save(film, steps.unwrap_or_default(), true) {
                Ok(()) => problem.with_help("its samples are kept; run the same command again"),
                Err(_) => problem,
            }
        })?;
        if written.not_finite > 0 {
            let black = counted(written.not_finite, "pixel");
            let (is, is_left) = match written.not_finite {
                1 => ("is not a finite number", "is"),
                _ => ("are not finite numbers", "are"),
            };
            self.terminal.warn(format_args!("{black} {is} and {is_left} left black"));
        }
        Ok(written.outcome)
    }
}

/// Watches a frame for the progress and the checkpoint.
struct Watch<'a> {
    progress: FrameProgress<'a>,
    checkpoint: Checkpoint,
    guide_file: GuideFile,
    display: Option<DisplayedImage<'a>>,
    /// Time that went into photons.
    photons: Mutex<Duration>,
    is_lost: &'a (dyn Fn() -> bool + Sync),
}

impl Observer for Watch<'_> {
    fn advanced(&self, share: f64) {
        self.progress.advanced(share);
    }

    fn resumed(&self, share: f64) {
        self.progress.resumed(share);
    }

    fn prepared(&self, time: Duration, share: f64) {
        *self.photons.lock().unwrap_or_else(|poisoned| poisoned.into_inner()) += time;
        self.progress.prepared(time, share);
    }

    fn learned(&self, field: &Field) {
        self.guide_file.write(field);
    }

    fn exposed(&self, tile: &Film) {
        if let Some(display) = &self.display {
            display.show(tile);
        }
    }

    fn should_stop(&self) -> bool {
        interrupt::requested() || (self.is_lost)()
    }

    fn gives_up(&self) -> bool {
        interrupt::was_long_ago()
    }

    fn wants_film(&self) -> bool {
        self.checkpoint.is_due()
    }

    fn keep(&self, film: Option<Film>, steps: Steps) {
        self.checkpoint.keep(film, steps);
    }
}

fn stopped(frame: i64, checkpoint: &Checkpoint, mut film: Film, steps: Steps) -> Problem {
    match checkpoint.save(&mut film, steps, false) {
        Ok(()) => Problem::new(Exit::Stopped, format!("interrupted in frame {frame}"))
            .with_help("its samples are kept; run the same command again to continue"),
        Err(error) => {
            let message =
                format!("interrupted in frame {frame}, whose samples can't be kept: {error}");
            Problem::new(Exit::Stopped, message)
        }
    }
}

fn cant_write(path: &Path, error: &io::Error) -> Problem {
    patience::problem(format_args!("write `{}`", path.display()), error)
}

/// Checks whether a picture can be written. The first frame makes the folder. If the folder
/// vanishes later, or can't be used for a while, the check passes and writing waits for the
/// folder.
pub(super) fn find_out_if_writable(path: &Path, is_first: bool) -> Result<(), Problem> {
    let check = match is_first {
        true => check_writable(path),
        false => check_free(path).or_else(|error| match patience::may_pass(&error) {
            true => Ok(()),
            false => Err(error),
        }),
    };
    check.map_err(|error| {
        Problem::new(Exit::CantCreate, format!("can't create `{}`: {error}", path.display()))
            .with_help("choose another folder with `--outdir`")
    })
}
