//! `--watch`: renders again whenever the scene or a file of it changes.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use super::once;
use crate::cli::base::{Exit, Problem, Terminal};
use crate::cli::files::{load, scene_file};
use crate::cli::options::Job;
use crate::cli::system::interrupt;
use slo_scene::files::Opened;
use slo_view::Watched;

/// Time between two looks at the files.
const BETWEEN_LOOKS: Duration = Duration::from_millis(100);

/// Looks at the files of a scene while it is rendered.
pub(super) struct Watcher {
    files: Mutex<(Watched, Instant)>,
    have_changed: AtomicBool,
}

impl Watcher {
    fn new(paths: impl IntoIterator<Item = PathBuf>) -> Self {
        let files = Mutex::new((Watched::new(paths), Instant::now()));
        Self { files, have_changed: AtomicBool::new(false) }
    }

    /// Whether a file has changed since it was read. Looks at the files now and then only.
    pub(super) fn have_changed(&self) -> bool {
        if let Ok(mut files) = self.files.try_lock()
            && files.1.elapsed() >= BETWEEN_LOOKS
        {
            files.1 = Instant::now();
            if files.0.have_changed() {
                self.have_changed.store(true, Ordering::Relaxed);
            }
        }
        self.have_changed.load(Ordering::Relaxed)
    }

    /// Looks at further files too.
    pub(super) fn add(&self, paths: impl IntoIterator<Item = PathBuf>) {
        self.files.lock().unwrap_or_else(PoisonError::into_inner).0.add(paths);
    }
}

/// Renders the job's frames, and again after each change, until a signal comes. What is wrong with the
/// scene is reported; it is tried again after the next change.
pub(super) fn run(job: &Job, terminal: Terminal) -> Result<(), Problem> {
    // The scene may have errors, but it must be there.
    load::file(job)?;
    loop {
        let opened = Opened::default();
        let watcher = Watcher::new(job.scene.as_ref().map(|path| scene_file::path_of(path, job)));
        let result = once(job, terminal, &opened, Some(&watcher));
        if interrupt::requested() {
            return result.and(Err(Problem::told(Exit::Stopped)));
        }
        if let Err(problem) = result.as_ref()
            && !watcher.have_changed()
            && !problem.message.is_empty()
        {
            terminal.error(&problem.message, &problem.help);
        }
        watcher.add(opened.paths());
        if !watcher.have_changed() {
            terminal.note("waiting for changes of the scene; Ctrl-C ends the program");
        }
        while !watcher.have_changed() {
            if interrupt::requested() {
                return Err(Problem::told(Exit::Stopped));
            }
            thread::sleep(BETWEEN_LOOKS);
        }
        // Programs save files in pieces.
        thread::sleep(BETWEEN_LOOKS);
    }
}
