//! Signs of life: this process changes its own claims at regular intervals and watches the claims
//! of others.

use std::collections::HashMap;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard};
use std::time::{Duration, Instant};

use super::note::{Note, period};

/// All claims that a process holds or has seen.
#[derive(Debug)]
pub(super) struct Pulse {
    /// How long this process waits for signs of life from others.
    pub(super) lease: Duration,
    state: Mutex<State>,
    ended: Condvar,
}

#[derive(Debug, Default)]
struct State {
    held: Vec<Arc<Held>>,
    seen: HashMap<PathBuf, Sight>,
    is_over: bool,
}

/// A claim of this process.
#[derive(Debug)]
pub(super) struct Held {
    pub(super) path: PathBuf,
    pub(super) token: String,
    /// The file that this process made, even if another file has its name by now: the process
    /// never writes to a claim that has replaced its own.
    file: Mutex<(File, Note)>,
    lost: AtomicBool,
}

/// Another process's claim, and how long it has not changed by the clock of this process.
#[derive(Debug)]
struct Sight {
    note: Note,
    at: Instant,
    still: Duration,
    /// Whether the claim was seen to change.
    is_alive: bool,
}

/// What another process's claim shows about its owner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sign {
    /// The claim has changed since it was first seen.
    Alive,
    /// It is too early to tell.
    Unknown,
    /// The claim has not changed for as long as this process waits, nor for several times its
    /// owner's interval between two signs of life.
    Dead,
}

impl Pulse {
    pub(super) fn new(lease: Duration) -> Self {
        Self { lease, state: Mutex::default(), ended: Condvar::new() }
    }

    /// Returns the time between two beats, and between two looks at the claims of others.
    pub(super) fn pause(&self) -> Duration {
        period(self.lease)
    }

    /// Gives signs of life and watches other claims until [`end`](Self::end).
    pub(super) fn run(&self) {
        loop {
            let state = lock(&self.state);
            let waited = self.ended.wait_timeout_while(state, self.pause(), |s| !s.is_over);
            let state = waited.unwrap_or_else(|poisoned| poisoned.into_inner()).0;
            if state.is_over {
                return;
            }
            // Slow files may delay this thread, but not the others: they need the lock.
            let held = state.held.clone();
            let seen: Vec<_> = state.seen.keys().cloned().collect();
            drop(state);
            held.iter().for_each(|held| held.beat());
            for path in seen {
                let _ = self.look(&path);
            }
        }
    }

    pub(super) fn end(&self) {
        lock(&self.state).is_over = true;
        self.ended.notify_all();
    }

    pub(super) fn hold(&self, held: &Arc<Held>) {
        let mut state = lock(&self.state);
        state.seen.remove(&held.path);
        state.held.push(Arc::clone(held));
    }

    /// Returns all claims of this process.
    pub(super) fn held(&self) -> Vec<Arc<Held>> {
        lock(&self.state).held.clone()
    }

    pub(super) fn let_go(&self, held: &Arc<Held>) {
        lock(&self.state).held.retain(|other| !Arc::ptr_eq(other, held));
    }

    /// Reads another process's claim and judges whether the owner is alive. From now on the claim
    /// is watched. Returns `None` if it is gone.
    ///
    /// # Errors
    /// Any I/O error, or something other than a file is there.
    pub(super) fn look(&self, path: &Path) -> io::Result<Option<(Note, Sign)>> {
        let note = match Note::read(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                lock(&self.state).seen.remove(path);
                if path.symlink_metadata().is_ok_and(|there| there.is_symlink()) {
                    let message = "it is a link that leads nowhere";
                    return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
                }
                return Ok(None);
            }
            note => note?,
        };
        let (now, most) = (Instant::now(), 2 * self.pause());
        let mut state = lock(&self.state);
        let sight = state
            .seen
            .entry(path.to_owned())
            .and_modify(|sight| sight.look(&note, now, most))
            .or_insert_with(|| Sight::new(note.clone(), now));
        let sign = match sight.is_alive {
            _ if sight.still >= self.lease.max(note.least_silence()) => Sign::Dead,
            true => Sign::Alive,
            false => Sign::Unknown,
        };
        Ok(Some((note, sign)))
    }
}

impl Sight {
    fn new(note: Note, at: Instant) -> Self {
        Self { note, at, still: Duration::ZERO, is_alive: false }
    }

    /// Looks again. A pause counts as `most` at most: a process that was suspended itself, or
    /// waited for an unreachable server, has not seen that the others did nothing.
    fn look(&mut self, note: &Note, now: Instant, most: Duration) {
        if self.note == *note {
            self.still += now.saturating_duration_since(self.at).min(most);
        } else {
            // A different claim in this place has not shown a sign of life yet.
            self.is_alive = self.note.token == note.token;
            (self.note, self.still) = (note.clone(), Duration::ZERO);
        }
        self.at = now;
    }
}

impl Held {
    pub(super) fn new(path: PathBuf, file: File, note: Note) -> Self {
        let token = note.token.clone();
        Self { path, token, file: Mutex::new((file, note)), lost: AtomicBool::new(false) }
    }

    /// Gives a sign of life. A failure to write it is ignored: at worst, another process takes
    /// over.
    fn beat(&self) {
        let mut file = lock(&self.file);
        let (file, note) = &mut *file;
        note.beats += 1;
        let _ = note.write(file);
        // The claim is lost only if another process's claim is in its place: a folder that is gone
        // may come back.
        let is_other = |there: Note| there.token != self.token;
        if Note::read(&self.path).is_ok_and(is_other) {
            self.lost.store(true, Ordering::Relaxed);
        }
    }

    /// Whether another process has taken over the claim.
    pub(super) fn is_lost(&self) -> bool {
        self.lost.load(Ordering::Relaxed)
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_time_that_was_watched_counts() {
        let seconds = Duration::from_secs;
        let mut note = Note::new(seconds(60), "");
        let start = Instant::now();
        let mut sight = Sight::new(note.clone(), start);
        let mut look = |note: &Note, after: u64| {
            sight.look(note, start + seconds(after), seconds(10));
            sight.still
        };
        assert_eq!(look(&note, 5), seconds(5));
        assert_eq!(look(&note, 10), seconds(10));
        assert_eq!(look(&note, 1000), seconds(20), "asleep");
        note.beats += 1;
        assert_eq!(look(&note, 1005), seconds(0), "it lives");
        assert_eq!(look(&note, 1000), seconds(0), "time goes on only");
    }

    #[test]
    fn who_waits_decides_how_long_but_respects_the_owners_period() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("claim");
        let seconds = Duration::from_secs;
        let dead_after = |owner: u64, watcher: u64| {
            let pulse = Pulse::new(seconds(watcher));
            let note = Note::new(seconds(owner), "");
            note.write(&mut File::create(&path).unwrap()).unwrap();
            assert_eq!(pulse.look(&path).unwrap().unwrap().1, Sign::Unknown);
            let since = |still| {
                lock(&pulse.state).seen.get_mut(&path).unwrap().still = seconds(still);
                pulse.look(&path).unwrap().unwrap().1 == Sign::Dead
            };
            (1..100_000).find(|&still| since(still)).unwrap()
        };
        assert_eq!(dead_after(60, 60), 60);
        assert_eq!(dead_after(86_400, 60), 60, "a day of the dead one's is nobody's day");
        assert_eq!(dead_after(2, 60), 60);
        assert_eq!(dead_after(86_400, 2), 15, "three signs of life, one every five seconds");
        assert_eq!(dead_after(2, 2), 2);
    }

    #[cfg(unix)]
    #[test]
    fn what_is_no_file_is_an_error_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        assert!(std::process::Command::new("mkfifo").arg(at("pipe")).status().unwrap().success());
        std::fs::create_dir(at("folder")).unwrap();
        std::os::unix::fs::symlink("/dev/null", at("device")).unwrap();
        std::os::unix::fs::symlink("nowhere", at("link")).unwrap();
        let pulse = Pulse::new(Duration::from_secs(60));
        for name in ["pipe", "folder", "device", "link"] {
            assert!(pulse.look(&at(name)).is_err(), "{name}");
        }
        assert!(pulse.look(&at("nothing")).unwrap().is_none());
    }
}
