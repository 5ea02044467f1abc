//! What is known of an unfinished frame, on disk, so that another run goes on from there.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::terminal::Terminal;
use crate::film::{Film, State, Subject, TooLarge};
use crate::output::{continues, read_state, remove_leftovers, steps_of, with_steps, write_state};
use crate::render::Steps;

/// A checkpoint may take this part of the time, at most: larger ones are written less often.
const SHARE_OF_TIME: u32 = 100;

/// The files of one frame's state.
pub(super) struct Checkpoint {
    subject: Subject,
    /// How far the picture goes is decided by the clock.
    is_timed: bool,
    /// Of a run that has not finished.
    unfinished: PathBuf,
    /// Of a picture that may get more samples.
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
    pub(super) fn new(
        path: &Path,
        subject: Subject,
        is_timed: bool,
        every: Option<Duration>,
        terminal: Terminal,
    ) -> Self {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        Self {
            subject,
            is_timed,
            unfinished: path.with_file_name(format!(".slo-rt-{name}.state")),
            kept: path.with_file_name(format!("{name}.state")),
            terminal,
            every,
            next: Mutex::new(Instant::now() + every.unwrap_or_default()),
            busy: AtomicBool::new(false),
            failed: AtomicBool::new(false),
        }
    }

    /// What earlier runs know of the frame; an unexposed film where there is nothing of use.
    pub(super) fn film(&self) -> Result<(Film, Steps), TooLarge> {
        let found = [&self.unfinished, &self.kept].map(|path| self.film_at(path));
        let samples = |(film, _): &(Film, Steps)| {
            film.pixels().iter().map(|p| u64::from(p.samples)).sum::<u64>()
        };
        match found.into_iter().flatten().max_by_key(samples) {
            Some(found) => Ok(found),
            None => self.subject.film().map(|film| (film, Steps::default())),
        }
    }

    fn film_at(&self, path: &Path) -> Option<(Film, Steps)> {
        match read_state(path) {
            Ok(State { subject, film, .. }) => {
                if subject.with_features != self.subject.with_features {
                    self.say_other_layers(path, subject.with_features);
                    return None;
                }
                let fits = subject.same_place(&self.subject);
                let last = Steps { done: Steps::LAST, tiles: 0 };
                let fits = fits && continues(&subject.recipe, &self.recipe(last));
                fits.then(|| (film, steps(&subject.recipe)))
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            Err(error) => {
                let path = path.display();
                self.terminal.warn(format_args!("`{path}` can't be used: {error}"));
                None
            }
        }
    }

    fn say_other_layers(&self, path: &Path, has_layers: bool) {
        let (has, wanted) = if has_layers { ("has", "does not") } else { ("has no", "does") };
        let path = path.display();
        self.terminal.warn(format_args!(
            "`{path}` can't be used: it {has} layers, and this run {wanted} write them"
        ));
    }

    /// Whether it is time to [`keep`](Self::keep) what is known. Whoever is told so has to do it.
    pub(super) fn is_due(&self) -> bool {
        let due =
            self.every.is_some() && self.next.try_lock().is_ok_and(|next| Instant::now() >= *next);
        due && !self.busy.swap(true, Ordering::AcqRel)
    }

    /// Writes what is known at this moment; that it can't be written is a warning, said once.
    pub(super) fn keep(&self, film: Film, steps: Steps) {
        let start = Instant::now();
        if let Err(error) = self.save(film, steps, false)
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
    pub(super) fn save(&self, film: Film, steps: Steps, is_complete: bool) -> io::Result<()> {
        self.write(&self.unfinished, film, steps, is_complete)
    }

    /// Keeps what is known of a finished picture.
    ///
    /// # Errors
    /// What the system says.
    pub(super) fn keep_finished(&self, film: Film, steps: Steps) -> io::Result<()> {
        self.write(&self.kept, film, steps, true)
    }

    fn write(&self, path: &Path, film: Film, steps: Steps, is_complete: bool) -> io::Result<()> {
        let subject = Subject { recipe: self.recipe(steps), ..self.subject.clone() };
        write_state(path, &State { subject, film, is_complete })
    }

    /// The recipe of a film that is to be taken to `steps`, where the clock decides about them.
    fn recipe(&self, steps: Steps) -> String {
        let recipe = self.subject.recipe.clone();
        if self.is_timed { with_steps(recipe, steps) } else { recipe }
    }

    /// Removes what a run left that was killed as it wrote.
    pub(super) fn remove_leftovers(&self) {
        [&self.unfinished, &self.kept].into_iter().for_each(|path| remove_leftovers(path));
    }

    /// The picture is in place: nothing is left to go on with.
    pub(super) fn remove(&self) {
        let _ = fs::remove_file(&self.unfinished);
    }
}

/// The steps of a recipe; none where it has none.
fn steps(recipe: &str) -> Steps {
    let parsed = serde_json::from_str(recipe).unwrap_or_default();
    steps_of(&parsed).unwrap_or_default()
}
