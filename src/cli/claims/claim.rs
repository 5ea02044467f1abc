//! Claims of this process: made, held, taken over, let go.

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

/// The claims of a process. Dropped, it gives no more signs of life.
#[derive(Debug)]
pub(crate) struct Claims {
    pub(super) pulse: Arc<Pulse>,
    thread: Option<JoinHandle<()>>,
}

/// A frame that is this process's to render. Dropped, it is free again.
#[derive(Debug)]
pub(crate) struct Claim {
    held: Arc<Held>,
    pulse: Arc<Pulse>,
    /// Of whom it was taken over.
    pub(crate) dead: Option<Worker>,
}

/// What came of asking for a frame.
#[derive(Debug)]
pub(crate) enum Taken {
    Mine(Claim),
    /// Another process renders it; `None`: it has just ended.
    Theirs(Option<Worker>),
    /// Another process renders it from another scene or with other settings.
    Other {
        worker: Worker,
        /// It gives signs of life.
        is_alive: bool,
    },
}

impl Claims {
    /// For a process that gives signs of life, and takes others for dead after `lease` without any.
    ///
    /// # Errors
    /// What the system says: no thread can be started.
    pub(crate) fn new(lease: Duration) -> io::Result<Self> {
        let pulse = Arc::new(Pulse::new(lease.clamp(SHORTEST_LEASE, LONGEST_LEASE)));
        let beating = Arc::clone(&pulse);
        let thread = std::thread::Builder::new().name("claims".into());
        let thread = thread.spawn(move || beating.run())?;
        let held = Arc::clone(&pulse);
        interrupt::before_the_end(move || held.held().iter().for_each(|held| let_go(held)));
        Ok(Self { pulse, thread: Some(thread) })
    }

    /// How long to wait before others may have got on.
    pub(crate) fn pause(&self) -> Duration {
        self.pulse.pause().min(Duration::from_millis(500))
    }

    /// Whether any process has the frame of `picture`, or has died with it.
    pub(crate) fn is_taken(&self, picture: &Path) -> bool {
        path_of(picture).exists()
    }

    /// Takes the frame of `picture`, whose folder exists, if no live process has it; `recipe` is a hash of
    /// what it is rendered from.
    ///
    /// # Errors
    /// What the system says.
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

    /// Replaces a dead claim by one of this process; `None` if another process does so, or its owner is
    /// alive after all.
    ///
    /// It is made under a name that holds the dead one's token, which one process can do, and then
    /// renamed, so that the frame is never without a claim. Who makes that name after the renaming
    /// finds another token in the dead one's place.
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
                // An heir may have died, too, in the moment before its renaming.
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
            // Whoever found that nobody needs it may have been faster.
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

    /// Keeps a claim alive that was made.
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
    /// Whether another process has taken this one for dead, and renders the frame now.
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

/// Removes a claim of this process, if it still is one.
fn let_go(held: &Held) {
    if is_at(&held.path, &held.token) {
        let _ = fs::remove_file(&held.path);
    }
}

/// Whether the claim at `path` is the one with that token.
fn is_at(path: &Path, token: &str) -> bool {
    Note::read(path).is_ok_and(|there| there.token == token)
}
