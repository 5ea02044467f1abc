//! What is known of an unfinished frame, on disk, so that another run goes on from there.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::terminal::Terminal;
use crate::film::{Film, State, Subject, TooLarge};
use crate::output::{continues, read_state, write_state};

/// A checkpoint may take this part of the time, at most: larger ones are written less often.
const SHARE_OF_TIME: u32 = 100;

/// The files of one frame's state.
pub(super) struct Checkpoint {
    subject: Subject,
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
        every: Option<Duration>,
        terminal: Terminal,
    ) -> Self {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        Self {
            subject,
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
    pub(super) fn film(&self) -> Result<Film, TooLarge> {
        let found = [&self.unfinished, &self.kept].map(|path| self.film_at(path));
        let samples = |film: &Film| film.pixels().iter().map(|p| u64::from(p.samples)).sum::<u64>();
        match found.into_iter().flatten().max_by_key(samples) {
            Some(film) => Ok(film),
            None => self.subject.film(),
        }
    }

    fn film_at(&self, path: &Path) -> Option<Film> {
        match read_state(path) {
            Ok(State { subject, film, .. }) => {
                let fits = subject.same_place(&self.subject);
                (fits && continues(&subject.recipe, &self.subject.recipe)).then_some(film)
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            Err(error) => {
                let path = path.display();
                self.terminal.warn(format_args!("`{path}` can't be used: {error}"));
                None
            }
        }
    }

    /// Whether it is time to [`keep`](Self::keep) what is known. Whoever is told so has to do it.
    pub(super) fn is_due(&self) -> bool {
        let due =
            self.every.is_some() && self.next.try_lock().is_ok_and(|next| Instant::now() >= *next);
        due && !self.busy.swap(true, Ordering::AcqRel)
    }

    /// Writes what is known at this moment; that it can't be written is a warning, said once.
    pub(super) fn keep(&self, film: Film) {
        let start = Instant::now();
        if let Err(error) = self.save(film, false)
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
    pub(super) fn save(&self, film: Film, is_complete: bool) -> io::Result<()> {
        self.write(&self.unfinished, film, is_complete)
    }

    /// Keeps what is known of a finished picture.
    ///
    /// # Errors
    /// What the system says.
    pub(super) fn keep_finished(&self, film: Film) -> io::Result<()> {
        self.write(&self.kept, film, true)
    }

    fn write(&self, path: &Path, film: Film, is_complete: bool) -> io::Result<()> {
        write_state(path, &State { subject: self.subject.clone(), film, is_complete })
    }

    /// The picture is in place: nothing is left to go on with.
    pub(super) fn remove(&self) {
        let _ = fs::remove_file(&self.unfinished);
    }
}
