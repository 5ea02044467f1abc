//! Rendering one frame to a file.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::interrupt::Guard;
use super::options::Job;
use super::problem::Problem;
use super::progress::Progress;
use super::summary::{Size, Times};
use super::terminal::Terminal;
use super::{Exit, load};
use crate::film::{Film, TooLarge};
use crate::frame::FrameScene;
use crate::output::{Info, Picture, Recipe, check_writable, file_name};
use crate::render::{Statistics, Unfinished, render};
use crate::scene::SceneDescription;

/// What rendering any frame of a job looks at.
#[derive(Clone, Copy)]
pub(super) struct Studio<'a> {
    pub(super) job: &'a Job,
    pub(super) scene: &'a SceneDescription,
    pub(super) terminal: Terminal,
}

/// A frame whose picture is in place.
#[derive(Debug)]
pub(super) struct Done {
    pub(super) path: PathBuf,
    pub(super) times: Times,
    pub(super) statistics: Statistics,
    pub(super) size: Size,
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
        let start = Instant::now();
        let built = load::frame(self.job, self.scene, frame)?;
        let building = start.elapsed();
        let start = Instant::now();
        let (film, statistics) = self.sample(frame, &built, expected, progress)?;
        let rendering = start.elapsed();
        let start = Instant::now();
        let path = self.target(frame, rendering);
        self.save(frame, &film, &path)?;
        let times =
            Times { loading: Duration::ZERO, building, rendering, writing: start.elapsed() };
        Ok(Done { path, times, statistics, size: Size::of(&built) })
    }

    /// Where a picture goes, had its rendering taken `time`.
    fn target(&self, frame: i64, time: Duration) -> PathBuf {
        let info = self.job.info.then_some(Info { settings: &self.scene.settings, time });
        self.job.outdir.join(file_name(&self.scene.camera.film, frame, info))
    }

    fn sample(
        &self,
        number: i64,
        frame: &FrameScene,
        path: &Path,
        progress: &Progress,
    ) -> Result<(Film, Statistics), Problem> {
        let _guard = Guard::new();
        let film = &self.scene.camera.film;
        let pixels = u64::from(film.width) * u64::from(film.height);
        render(frame, &progress.frame(number, path, pixels)).map_err(unfinished)
    }

    fn save(&self, frame: i64, film: &Film, path: &Path) -> Result<(), Problem> {
        let _guard = Guard::new();
        let image = film.image();
        let settings = &self.scene.camera.film;
        let (format, encoding) = (settings.output, settings.encoding);
        let recipe = Recipe { scene: self.scene, frame }.to_json();
        let picture = Picture { image: &image, format, encoding, recipe: &recipe };
        let black = picture.not_finite();
        if black > 0 {
            self.terminal.warn(format_args!("{black} pixels are no numbers and were left black"));
        }
        picture.save(path).map_err(|error| {
            Problem::new(Exit::Failed, format!("can't write `{}`: {error}", path.display()))
        })
    }
}

fn find_out_if_writable(path: &Path) -> Result<(), Problem> {
    check_writable(path).map_err(|error| {
        Problem::new(Exit::CantCreate, format!("can't create `{}`: {error}", path.display()))
            .with_help("`--outdir` names another folder")
    })
}

fn unfinished(why: Unfinished) -> Problem {
    match why {
        Unfinished::Stopped => {
            Problem::new(Exit::Interrupted, "interrupted; no picture was written")
        }
        Unfinished::TooLarge(TooLarge { bytes }) => {
            let message = format!("the picture needs {:.1} GB of memory", bytes as f64 / 1e9);
            Problem::new(Exit::Failed, message).with_help("`--size` makes it smaller")
        }
    }
}
