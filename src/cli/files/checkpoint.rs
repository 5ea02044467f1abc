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
    continues, has_same_samples, made_by_others, read_state, remove_abandoned, remove_leftovers,
    steps_of, with_steps, write_state,
};

/// Checkpoints take at most one part in so many of the time: larger ones are written less often.
const SHARE_OF_TIME: u32 = 100;

/// The files of one frame's state.
pub(crate) struct Checkpoint {
    subject: Subject,
    /// Whether the clock decides how far the picture is taken.
    is_timed: bool,
    /// Path of the state if this run does not finish. Its name holds a hash of the recipe, so that
    /// no other run of the picture replaces it.
    unfinished: PathBuf,
    /// Paths of the states of other runs that have not finished the picture: with other recipes or
    /// under older names.
    others: Vec<PathBuf>,
    /// Files that are no longer needed once the picture is in place.
    spent: Mutex<Vec<PathBuf>>,
    /// Path of the state of a picture that may get more samples, in whatever file format.
    kept: PathBuf,
    terminal: Terminal,
    every: Option<Duration>,
    /// Time when the next checkpoint is due.
    next: Mutex<Instant>,
    /// Whether a thread is writing.
    busy: AtomicBool,
    /// Whether writing has failed, which was reported.
    failed: AtomicBool,
}

impl Checkpoint {
    /// Prepares the state of the picture at `path`.
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

    /// Returns the film with the most samples from earlier runs of the frame, or an unexposed film
    /// if there is none to use.
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
                Some((*film, steps))
            }
        });
        let kept = match self.film_at(&self.kept) {
            Found::Film(film, steps) => Some((*film, steps)),
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
                if !subject.same_layers(&self.subject) {
                    self.say_other_layers(path, &subject);
                    return Found::None;
                }
                let fits = subject.same_place(&self.subject);
                if fits {
                    Found::Film(Box::new(film), steps(&subject.recipe))
                } else {
                    Found::OfAnotherRun
                }
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => Found::None,
            Err(error) => {
                let path = path.display();
                self.terminal.warn(format_args!("`{path}` can't be used: {error}"));
                // A file that can't be read now may be readable later.
                match error.kind() {
                    io::ErrorKind::InvalidData => Found::Damaged,
                    _ => Found::None,
                }
            }
        }
    }

    fn say_other_layers(&self, path: &Path, found: &Subject) {
        let path = path.display();
        let own = &self.subject;
        let (has_layers, what) = if found.with_features != own.with_features {
            (found.with_features, "layers")
        } else if found.light_groups != own.light_groups {
            (found.light_groups.is_some(), "layers of lights")
        } else {
            self.terminal.warn(format_args!(
                "`{path}` can't be used: its layers for compositors are not those that this run writes"
            ));
            return;
        };
        let (has, wanted) =
            if has_layers { ("has", "does not write") } else { ("has no", "writes") };
        self.terminal.warn(format_args!(
            "`{path}` can't be used: it {has} {what}, but this run {wanted} them"
        ));
    }

    /// Whether it is time to [`keep`](Self::keep) the film. A caller that gets `true` must keep
    /// it.
    pub(crate) fn is_due(&self) -> bool {
        let due =
            self.every.is_some() && self.next.try_lock().is_ok_and(|next| Instant::now() >= *next);
        due && !self.busy.swap(true, Ordering::AcqRel)
    }

    /// Writes a checkpoint of the film. If it can't be written, or there was no memory for the
    /// film, the program warns once.
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

    /// Writes the state of an unfinished frame.
    ///
    /// # Errors
    /// Any I/O error.
    pub(crate) fn save(&self, film: &mut Film, steps: Steps, is_complete: bool) -> io::Result<()> {
        self.with_state(film, steps, is_complete, |state| write_state(&self.unfinished, state))
    }

    /// Writes the state of an unfinished frame as soon as that works.
    ///
    /// # Errors
    /// The errors of [`patience::write`].
    pub(crate) fn save_patiently(&self, film: &mut Film, steps: Steps) -> io::Result<()> {
        self.with_state(film, steps, true, |state| self.write_patiently(&self.unfinished, state))
    }

    /// Keeps the state of a finished picture. If the kept state already has more samples of the
    /// picture, it stays, and a warning says so. A file of another program is replaced only if
    /// `forced`.
    ///
    /// # Errors
    /// The errors of [`patience::write`].
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

    /// Returns the path of the state of an unfinished frame.
    pub(crate) fn unfinished(&self) -> &Path {
        &self.unfinished
    }

    /// Returns the path of the state of a finished picture.
    pub(crate) fn kept(&self) -> &Path {
        &self.kept
    }

    fn write_patiently(&self, path: &Path, state: &State) -> io::Result<()> {
        patience::write(path, self.terminal, || write_state(path, state))
    }

    /// Calls `write` with a state that takes the film in, and then gives the film back: there may
    /// not be memory for two films.
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

    /// Returns the recipe of a film. It includes `steps` if the clock decides them.
    fn recipe(&self, steps: Steps) -> String {
        recipe(&self.subject, self.is_timed, steps)
    }

    /// Removes the files that a run left behind when it was killed while writing.
    pub(crate) fn remove_leftovers(&self) {
        [&self.unfinished, &self.kept].into_iter().for_each(|path| remove_leftovers(path));
    }

    /// Turns the state of an unfinished frame into the kept state of a finished picture.
    ///
    /// # Errors
    /// Any I/O error.
    pub(crate) fn keep_unfinished(&self) -> io::Result<()> {
        fs::rename(&self.unfinished, &self.kept)
    }

    /// Removes the states when the picture is in place.
    pub(crate) fn remove(&self) {
        let spent = self.spent.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        for path in spent.iter().chain([&self.unfinished]) {
            let _ = fs::remove_file(path);
        }
        remove_abandoned(&self.unfinished);
    }
}

/// Returns the path of the state of a run that has not finished the picture at `path`. The name
/// holds a hash of the recipe.
pub(crate) fn unfinished(path: &Path, subject: &Subject, is_timed: bool) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".slo-rt-{name}.{}.state", &recipe_hash(subject, is_timed)[..8]))
}

/// The names of all states of unfinished runs in a folder.
pub(crate) fn states_in(folder: &Path) -> Vec<String> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let names = fs::read_dir(folder).into_iter().flatten().flatten();
    let names = names.filter_map(|entry| entry.file_name().into_string().ok());
    names.filter(|name| name.starts_with(".slo-rt-") && name.ends_with(".state")).collect()
}

/// Returns a hash of what a picture is rendered from, in hexadecimal.
pub(crate) fn recipe_hash(subject: &Subject, is_timed: bool) -> String {
    let recipe = recipe(subject, is_timed, Steps::default());
    blake3::hash(recipe.as_bytes()).to_hex()[..16].to_owned()
}

/// What a state file holds for a run.
enum Found {
    /// Nothing, or nothing that this run can use now, which was reported.
    None,
    /// Nothing that any run could use.
    Damaged,
    /// Samples that this run can't continue from.
    OfAnotherRun,
    /// A film that this run continues from.
    Film(Box<Film>, Steps),
}

/// Returns the state files of unfinished runs of the picture at `path`, except `own`.
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

/// Returns the recipe of a film. It includes `steps` if the clock decides them.
fn recipe(subject: &Subject, is_timed: bool, steps: Steps) -> String {
    let recipe = subject.recipe.clone();
    if is_timed { with_steps(recipe, steps) } else { recipe }
}

/// Returns the steps of a recipe, or zero if it has none.
fn steps(recipe: &str) -> Steps {
    let parsed = serde_json::from_str(recipe).unwrap_or_default();
    steps_of(&parsed).unwrap_or_default()
}
