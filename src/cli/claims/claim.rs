//! Claims of this process: making, holding, taking over and releasing them.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use super::note::{Note, Worker, path_of};
use super::pulse::{Held, Pulse, Sign};
use crate::cli::system::interrupt;
use crate::cli::values::{LONGEST_LEASE, SHORTEST_LEASE};

/// The claims of a process. When they are dropped, the process gives no more signs of life.
#[derive(Debug)]
pub(crate) struct Claims {
    pub(super) pulse: Arc<Pulse>,
    thread: Option<JoinHandle<()>>,
}

/// A frame that this process may render. When the claim is dropped, the frame is free again.
#[derive(Debug)]
pub(crate) struct Claim {
    held: Arc<Held>,
    pulse: Arc<Pulse>,
    /// The dead process from which the frame was taken over.
    pub(crate) dead: Option<Worker>,
}

/// Result of asking for a frame.
#[derive(Debug)]
pub(crate) enum Taken {
    Mine(Claim),
    /// Another process renders it. `None`: its claim has just gone.
    Theirs(Option<Worker>),
    /// Another process renders it from another scene or with other settings.
    Other {
        worker: Worker,
        /// Whether the other process gives signs of life.
        is_alive: bool,
    },
}

impl Claims {
    /// Starts to give signs of life. Other processes count as dead after `lease` without one.
    ///
    /// # Errors
    /// The system can't start a thread.
    pub(crate) fn new(lease: Duration) -> io::Result<Self> {
        let pulse = Arc::new(Pulse::new(lease.clamp(SHORTEST_LEASE, LONGEST_LEASE)));
        let beating = Arc::clone(&pulse);
        let thread = std::thread::Builder::new().name("claims".into());
        let thread = thread.spawn(move || beating.run())?;
        let held = Arc::clone(&pulse);
        interrupt::before_the_end(move || held.held().iter().for_each(|held| let_go(held)));
        Ok(Self { pulse, thread: Some(thread) })
    }

    /// Returns how long to wait before other processes may have made progress.
    pub(crate) fn pause(&self) -> Duration {
        self.pulse.pause().min(Duration::from_millis(500))
    }

    /// Whether a process, alive or dead, holds the frame of `picture`.
    pub(crate) fn is_taken(&self, picture: &Path) -> bool {
        path_of(picture).exists()
    }

    /// Takes the frame of `picture` if no live process has it. The folder of `picture` must exist.
    /// `recipe` is a hash of what the frame is rendered from.
    ///
    /// # Errors
    /// Any I/O error.
    pub(crate) fn take(&self, picture: &Path, recipe: &str) -> io::Result<Taken> {
        let path = path_of(picture);
        match self.make(&path, recipe) {
            Ok(made) => return Ok(Taken::Mine(self.hold(path, made, None))),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
        let Some((note, sign)) = self.pulse.look(&path)? else { return Ok(Taken::Theirs(None)) };
        let made = match sign {
            Sign::Dead => self.take_over(&path, &note, recipe)?,
            Sign::Alive | Sign::Unknown => None,
        };
        let is_other = note.is_of_other(recipe);
        let worker = note.worker;
        Ok(match made {
            Some(made) => Taken::Mine(self.hold(path, made, Some(worker))),
            None if is_other => Taken::Other { worker, is_alive: sign == Sign::Alive },
            None => Taken::Theirs(Some(worker)),
        })
    }

    /// Replaces a dead claim with a claim of this process. Returns `None` if another process does
    /// so, or if the owner is alive after all.
    ///
    /// The new claim is first made under a name that holds the token of the dead claim, which only
    /// one process can do. Then it is renamed, so the frame is never without a claim. A process
    /// that makes a file of this name after the renaming finds another token in the place of the
    /// dead claim's, and gives up.
    pub(super) fn take_over(
        &self,
        path: &Path,
        dead: &Note,
        recipe: &str,
    ) -> io::Result<Option<(File, Note)>> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let heir = path.with_file_name(format!("{name}.{}", dead.token));
        let made = match self.make(&heir, recipe) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                // Another process may have died just before it renamed its new claim.
                if self.pulse.look(&heir)?.is_some_and(|(_, sign)| sign == Sign::Dead) {
                    let _ = fs::remove_file(&heir);
                }
                return Ok(None);
            }
            made => made?,
        };
        if Note::read(path).is_ok_and(|there| there == *dead) {
            let renamed = fs::rename(&heir, path);
            renamed.inspect_err(|_| drop(fs::remove_file(&heir)))?;
        } else {
            // Another process may have found this file abandoned and removed it first.
            let _ = fs::remove_file(&heir);
        }
        Ok(is_at(path, &made.1.token).then_some(made))
    }

    /// Makes a claim at a path that does not exist.
    fn make(&self, path: &Path, recipe: &str) -> io::Result<(File, Note)> {
        let mut file = File::create_new(path)?;
        let note = Note::new(self.pulse.lease, recipe);
        note.write(&mut file).inspect_err(|_| drop(fs::remove_file(path)))?;
        Ok((file, note))
    }

    /// Keeps a new claim alive.
    fn hold(&self, path: PathBuf, (file, note): (File, Note), dead: Option<Worker>) -> Claim {
        let held = Arc::new(Held::new(path, file, note));
        self.pulse.hold(&held);
        Claim { held, pulse: Arc::clone(&self.pulse), dead }
    }
}

impl Drop for Claims {
    fn drop(&mut self) {
        self.pulse.end();
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

impl Claim {
    /// Whether another process has declared this process dead and renders the frame now.
    pub(crate) fn is_lost(&self) -> bool {
        self.held.is_lost()
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        self.pulse.let_go(&self.held);
        let_go(&self.held);
    }
}

/// Removes a claim if it still belongs to this process.
fn let_go(held: &Held) {
    if is_at(&held.path, &held.token) {
        let _ = fs::remove_file(&held.path);
    }
}

/// Whether the claim at `path` has this token.
fn is_at(path: &Path, token: &str) -> bool {
    Note::read(path).is_ok_and(|there| there.token == token)
}
