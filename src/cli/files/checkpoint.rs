//! The state of an unfinished frame on disk, from which another run continues.

use std::ffi::OsString;
use std::fs;
use std::io;
use std::mem;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::cli::base::Terminal;
use crate::cli::system::patience;
use slo_picture::film::Steps;
use slo_picture::film::{Film, State, Subject, TooLarge};
use slo_picture::output::{
    continues, has_same_samples, made_by_others, read_state, remove_leftovers, steps_of,
    with_steps, write_state,
};

/// A checkpoint may take this part of the time, at most: larger ones are written less often.
const SHARE_OF_TIME: u32 = 100;

/// The files of one frame's state.
pub(crate) struct Checkpoint {
    subject: Subject,
    /// How far the picture goes is decided by the clock.
    is_timed: bool,
    /// Of this run, if it does not finish: its name holds a hash of the recipe, so that no other run of the
    /// picture takes its place.
    unfinished: PathBuf,
    /// Of runs of other recipes, or of older names, that have not finished the picture.
    others: Vec<PathBuf>,
    /// What is of no use any more when the picture is there.
    spent: Mutex<Vec<PathBuf>>,
    /// Of a picture that may get more samples, in whatever file format.
    kept: PathBuf,
    terminal: Terminal,
    every: Option<Duration>,
    /// When a checkpoint is due.
    next: Mutex<Instant>,
    /// A thread writes.
    busy: AtomicBool,
    /// Writing failed, and that was said.
    failed: AtomicBool,
}

impl Checkpoint {
    /// For the picture at `path`.
    pub(crate) fn new(
        path: &Path,
        subject: Subject,
        is_timed: bool,
        every: Option<Duration>,
        terminal: Terminal,
    ) -> Self {
        let unfinished = unfinished(path, &subject, is_timed);
        Self {
            subject,
            is_timed,
            others: unfinished_of(path, &unfinished),
            unfinished,
            spent: Mutex::default(),
            kept: path.with_extension("state"),
            terminal,
            every,
            next: Mutex::new(Instant::now() + every.unwrap_or_default()),
            busy: AtomicBool::new(false),
            failed: AtomicBool::new(false),
        }
    }

    /// The film of earlier runs of the frame; an unexposed one if there is nothing of use.
    pub(crate) fn film(&self) -> Result<(Film, Steps), TooLarge> {
        let unfinished = self.others.iter().chain([&self.unfinished]);
        let found = unfinished.filter_map(|path| match self.film_at(path) {
            Found::None => None,
            Found::OfAnotherRun => {
                let path = path.display();
                self.terminal
                    .note(format_args!("`{path}` belongs to another run and is left alone"));
                None
            }
            Found::Damaged => {
                self.is_spent(path);
                None
            }
            Found::Film(film, steps) => {
                self.is_spent(path);
                Some((film, steps))
            }
        });
        let kept = match self.film_at(&self.kept) {
            Found::Film(film, steps) => Some((film, steps)),
            _ => None,
        };
        match found.chain(kept).max_by_key(|(film, _)| samples(film)) {
            Some(found) => Ok(found),
            None => self.subject.film().map(|film| (film, Steps::default())),
        }
    }

    fn is_spent(&self, path: &Path) {
        let mut spent = self.spent.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        spent.push(path.to_owned());
    }

    fn film_at(&self, path: &Path) -> Found {
        match read_state(path) {
            Ok(State { subject, film, .. }) => {
                let last = Steps { done: Steps::LAST, tiles: 0 };
                if !continues(&subject.recipe, &self.recipe(last)) {
                    return Found::OfAnotherRun;
                }
                if subject.with_features != self.subject.with_features {
                    self.say_other_layers(path, subject.with_features);
                    return Found::None;
                }
                let fits = subject.same_place(&self.subject);
                if fits { Found::Film(film, steps(&subject.recipe)) } else { Found::OfAnotherRun }
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => Found::None,
            Err(error) => {
                let path = path.display();
                self.terminal.warn(format_args!("`{path}` can't be used: {error}"));
                // What can't be read now may be read another time.
                match error.kind() {
                    io::ErrorKind::InvalidData => Found::Damaged,
                    _ => Found::None,
                }
            }
        }
    }

    fn say_other_layers(&self, path: &Path, has_layers: bool) {
        let (has, wanted) =
            if has_layers { ("has", "does not write") } else { ("has no", "writes") };
        let path = path.display();
        self.terminal.warn(format_args!(
            "`{path}` can't be used: it {has} layers, but this run {wanted} them"
        ));
    }

    /// Whether it is time to [`keep`](Self::keep) what is known. The caller that gets `true` must keep it.
    pub(crate) fn is_due(&self) -> bool {
        let due =
            self.every.is_some() && self.next.try_lock().is_ok_and(|next| Instant::now() >= *next);
        due && !self.busy.swap(true, Ordering::AcqRel)
    }

    /// Writes what is known at this moment. If it can't be written, or there was no memory for it, the
    /// program warns once.
    pub(crate) fn keep(&self, film: Option<Film>, steps: Steps) {
        let start = Instant::now();
        let saved = match film {
            Some(mut film) => self.save(&mut film, steps, false),
            None => Err(io::ErrorKind::OutOfMemory.into()),
        };
        if let Err(error) = saved
            && !self.failed.swap(true, Ordering::Relaxed)
        {
            let path = self.unfinished.display();
            self.terminal.warn(format_args!("can't write the checkpoint `{path}`: {error}"));
        }
        let pause = (start.elapsed() * SHARE_OF_TIME).max(self.every.unwrap_or_default());
        *self.next.lock().unwrap_or_else(|poisoned| poisoned.into_inner()) = Instant::now() + pause;
        self.busy.store(false, Ordering::Release);
    }

    /// Writes what is known of an unfinished frame.
    ///
    /// # Errors
    /// What the system says.
    pub(crate) fn save(&self, film: &mut Film, steps: Steps, is_complete: bool) -> io::Result<()> {
        self.with_state(film, steps, is_complete, |state| write_state(&self.unfinished, state))
    }

    /// The same as soon as it works.
    ///
    /// # Errors
    /// As [`patience::write`].
    pub(crate) fn save_patiently(&self, film: &mut Film, steps: Steps) -> io::Result<()> {
        self.with_state(film, steps, true, |state| self.write_patiently(&self.unfinished, state))
    }

    /// Keeps what is known of a finished picture, unless what is kept already has more samples of
    /// it, which a warning says. A file of another program is replaced only if `forced`.
    ///
    /// # Errors
    /// As [`patience::write`].
    pub(crate) fn keep_finished(
        &self,
        film: &mut Film,
        steps: Steps,
        forced: bool,
    ) -> io::Result<()> {
        let path = self.kept.display();
        if let Some(why) = made_by_others(&self.kept).filter(|_| !forced) {
            let message = format!(
                "slo-rt did not make the existing file ({why}); move it away, or replace it \
                 with `--overwrite`"
            );
            return Err(io::Error::new(io::ErrorKind::AlreadyExists, message));
        }
        if let Ok(State { subject, film: there, .. }) = read_state(&self.kept) {
            let is_same = subject.same_place(&self.subject)
                && has_same_samples(&subject.recipe, &self.subject.recipe);
            if is_same && samples(&there) > samples(film) {
                let more = "has more samples than this picture and is kept";
                self.terminal.warn(format_args!("`{path}` {more}"));
                return Ok(());
            }
            if !is_same {
                let other = "belonged to another scene or other settings and is replaced";
                self.terminal.warn(format_args!("`{path}` {other}"));
            }
        }
        self.with_state(film, steps, true, |state| self.write_patiently(&self.kept, state))
    }

    /// Where what is known of an unfinished frame lies.
    pub(crate) fn unfinished(&self) -> &Path {
        &self.unfinished
    }

    /// Where what is known of a finished picture lies.
    pub(crate) fn kept(&self) -> &Path {
        &self.kept
    }

    fn write_patiently(&self, path: &Path, state: &State) -> io::Result<()> {
        patience::write(path, self.terminal, || write_state(path, state))
    }

    /// What `write` makes of a state that takes the film in, and gives it back: there may not be memory for two.
    fn with_state(
        &self,
        film: &mut Film,
        steps: Steps,
        is_complete: bool,
        write: impl FnOnce(&State) -> io::Result<()>,
    ) -> io::Result<()> {
        let subject = Subject { recipe: self.recipe(steps), ..self.subject.clone() };
        let state = State { subject, film: mem::take(film), is_complete };
        let written = write(&state);
        *film = state.film;
        written
    }

    /// The recipe of a film that is taken to `steps`, if the clock decides about them.
    fn recipe(&self, steps: Steps) -> String {
        recipe(&self.subject, self.is_timed, steps)
    }

    /// Removes what a run left that was killed as it wrote.
    pub(crate) fn remove_leftovers(&self) {
        [&self.unfinished, &self.kept].into_iter().for_each(|path| remove_leftovers(path));
    }

    /// Keeps what is known of an unfinished frame as that of a finished picture.
    ///
    /// # Errors
    /// What the system says.
    pub(crate) fn keep_unfinished(&self) -> io::Result<()> {
        fs::rename(&self.unfinished, &self.kept)
    }

    /// Removes the states: the picture is in place.
    pub(crate) fn remove(&self) {
        let spent = self.spent.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        for path in spent.iter().chain([&self.unfinished]) {
            let _ = fs::remove_file(path);
        }
    }
}

/// Path of the state of a run that has not finished the picture at `path`: the name holds a hash of
/// the recipe.
pub(crate) fn unfinished(path: &Path, subject: &Subject, is_timed: bool) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".slo-rt-{name}.{}.state", &recipe_hash(subject, is_timed)[..8]))
}

/// A hash of what a picture is rendered from, in hexadecimal.
pub(crate) fn recipe_hash(subject: &Subject, is_timed: bool) -> String {
    let recipe = recipe(subject, is_timed, Steps::default());
    blake3::hash(recipe.as_bytes()).to_hex()[..16].to_owned()
}

/// What a file of a state holds for a run.
enum Found {
    /// Nothing, or nothing that this run can use now, which was said.
    None,
    /// Nothing that anybody could use.
    Damaged,
    /// Samples that are no beginning of this run's.
    OfAnotherRun,
    /// What this run continues from.
    Film(Film, Steps),
}

/// The files of unfinished runs of the picture at `path`, all but `own`.
fn unfinished_of(path: &Path, own: &Path) -> Vec<PathBuf> {
    let start = [".slo-rt-".as_ref(), path.file_name().unwrap_or_default(), ".".as_ref()];
    let start: OsString = start.into_iter().collect();
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let entries = fs::read_dir(folder.unwrap_or(Path::new(".")));
    let is_one = |name: &OsString| {
        let name = name.as_encoded_bytes();
        name.starts_with(start.as_encoded_bytes()) && name.ends_with(b".state")
    };
    let names = entries.into_iter().flatten().flatten().map(|entry| entry.file_name());
    let paths = names.filter(is_one).map(|name| path.with_file_name(name));
    let mut paths: Vec<PathBuf> = paths.filter(|path| path != own).collect();
    paths.sort();
    paths
}

fn samples(film: &Film) -> u64 {
    film.pixels().iter().map(|pixel| u64::from(pixel.samples)).sum()
}

/// The recipe of a film that is taken to `steps`, if the clock decides about them.
fn recipe(subject: &Subject, is_timed: bool, steps: Steps) -> String {
    let recipe = subject.recipe.clone();
    if is_timed { with_steps(recipe, steps) } else { recipe }
}

/// The steps of a recipe; zero if it has none.
fn steps(recipe: &str) -> Steps {
    let parsed = serde_json::from_str(recipe).unwrap_or_default();
    steps_of(&parsed).unwrap_or_default()
}
