//! Rendering one frame to a file.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::interrupt::Guard;
use super::options::Job;
use super::problem::Problem;
use super::progress::Progress;
use super::summary::Summary;
use super::terminal::{Terminal, print};
use super::{Exit, load};
use crate::film::{Film, TooLarge};
use crate::frame::FrameScene;
use crate::output::{Info, Picture, Recipe, check_writable, file_name, read_recipe};
use crate::render::{Statistics, Unfinished, render};
use crate::scene::SceneDescription;

/// Renders the job's frame, prints the path of its picture, and says how it went.
pub(super) fn run(job: &Job, terminal: Terminal) -> Result<(), Problem> {
    let start = Instant::now();
    let threads = load::threads(job.threads)?;
    let scene = threads.install(|| load::scene(job, terminal))?;
    let loading = start.elapsed();
    let run = Run { job, scene: &scene, terminal };
    match (job.threads, scene.settings.parallel_threads) {
        (None, Some(asked)) => load::threads(Some(asked as usize))?.install(|| run.go(loading)),
        _ => threads.install(|| run.go(loading)),
    }
}

/// What all steps of a rendering look at.
struct Run<'a> {
    job: &'a Job,
    scene: &'a SceneDescription,
    terminal: Terminal,
}

impl Run<'_> {
    fn go(&self, loading: Duration) -> Result<(), Problem> {
        let recipe = Recipe { scene: self.scene, frame: self.job.frame() }.to_json();
        let expected = self.target(Duration::ZERO);
        if self.job.skip_existing && has_recipe(&expected, &recipe) {
            self.terminal.note(format_args!("`{}` is there already", expected.display()));
            return print_path(&expected);
        }
        find_out_if_writable(&expected)?;
        let start = Instant::now();
        let frame = load::frame(self.job, self.scene)?;
        let building = start.elapsed();
        let start = Instant::now();
        let (film, statistics) = self.sample(&frame)?;
        let rendering = start.elapsed();
        let start = Instant::now();
        let path = self.target(rendering);
        self.save(&film, &recipe, &path)?;
        print_path(&path)?;
        let writing = start.elapsed();
        Summary {
            loading,
            building,
            rendering,
            writing,
            statistics,
            frame: &frame,
            isa: self.job.isa,
        }
        .tell(self.scene, self.terminal);
        Ok(())
    }

    /// Where the picture goes, had its rendering taken `time`.
    fn target(&self, time: Duration) -> PathBuf {
        let info = self.job.info.then_some(Info { settings: &self.scene.settings, time });
        self.job.outdir.join(file_name(&self.scene.camera.film, self.job.frame(), info))
    }

    fn sample(&self, frame: &FrameScene) -> Result<(Film, Statistics), Problem> {
        let _guard = Guard::new();
        let film = &self.scene.camera.film;
        let pixels = u64::from(film.width) * u64::from(film.height);
        let title = format!("frame {}", self.job.frame());
        let progress = Progress::new(pixels, &title, self.terminal);
        render(frame, &progress).map_err(unfinished)
    }

    fn save(&self, film: &Film, recipe: &str, path: &Path) -> Result<(), Problem> {
        let _guard = Guard::new();
        let image = film.image();
        let settings = &self.scene.camera.film;
        let (format, encoding) = (settings.output, settings.encoding);
        let picture = Picture { image: &image, format, encoding, recipe };
        let black = picture.not_finite();
        if black > 0 {
            self.terminal.warn(format_args!("{black} pixels are no numbers and were left black"));
        }
        picture.save(path).map_err(|error| {
            Problem::new(Exit::Failed, format!("can't write `{}`: {error}", path.display()))
        })
    }
}

fn has_recipe(path: &Path, recipe: &str) -> bool {
    read_recipe(path).is_ok_and(|found| found == recipe)
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

fn print_path(path: &Path) -> Result<(), Problem> {
    print(path.as_os_str().as_encoded_bytes()).map_err(|error| {
        Problem::new(Exit::Failed, format!("can't print the picture's path: {error}"))
    })
}
