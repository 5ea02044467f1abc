//! Contents of a claim.

use std::collections::hash_map::RandomState;
use std::fmt;
use std::fs::File;
use std::hash::{BuildHasher, Hasher};
use std::io::{self, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::process;
use std::time::Duration;

use crate::cli::values::{LONGEST_LEASE, SHORTEST_LEASE};
use slo_picture::output::open_regular;

/// Maximum number of bytes to read. Every claim is shorter.
const MOST: u64 = 512;
/// Maximum number of characters shown of a host's name.
const LONGEST_HOST: usize = 64;
/// Longest time between two signs of life, regardless of the lease.
const LONGEST_PERIOD: Duration = Duration::from_secs(5);
/// Number of signs of life in a short lease.
const BEATS_OF_A_LEASE: u32 = 12;
/// Token of a claim without one, whose owner died between making and filling it.
const NO_TOKEN: &str = "0";

/// Returns the path of the claim on a picture.
pub(super) fn path_of(picture: &Path) -> PathBuf {
    let name = picture.file_name().unwrap_or_default().to_string_lossy();
    picture.with_file_name(format!(".slo-rt-{name}.claim"))
}

/// A process that renders frames, as shown to people.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Worker {
    host: String,
    process: u32,
}

impl Worker {
    fn me() -> Self {
        let kernel = std::fs::read_to_string("/proc/sys/kernel/hostname").ok();
        let variable = |name| std::env::var(name).ok();
        let host = kernel.or_else(|| variable("HOSTNAME")).or_else(|| variable("COMPUTERNAME"));
        Self { host: shown(&host.unwrap_or_default()), process: process::id() }
    }
}

impl fmt::Display for Worker {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "process {} on {}", self.process, self.host)
    }
}

/// Removes the characters from a host's name that a terminal would take for a command, and
/// shortens it.
fn shown(host: &str) -> String {
    let plain = host.trim().chars().filter(|c| !c.is_control() && !c.is_whitespace());
    let host: String = plain.take(LONGEST_HOST).collect();
    if host.is_empty() { "another machine".into() } else { host }
}

/// Returns the time between two signs of life of a process with this lease.
pub(super) fn period(lease: Duration) -> Duration {
    (lease / BEATS_OF_A_LEASE).min(LONGEST_PERIOD)
}

/// A claim as read: its owner, and what the owner promises.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Note {
    /// Unique to this claim among all processes.
    pub(super) token: String,
    pub(super) worker: Worker,
    /// How long the owner waits for a sign of life from others. Its own signs follow each other
    /// after the [`period`] of this lease.
    pub(super) lease: Duration,
    /// Number of times that the claim was changed.
    pub(super) beats: u64,
    /// Hash of what the frame is rendered from; `None` if the claim does not say.
    pub(super) recipe: Option<String>,
}

impl Note {
    /// Makes a claim of this process. `recipe` is the hash of what it renders from.
    pub(super) fn new(lease: Duration, recipe: &str) -> Self {
        let token = format!("{:016x}", RandomState::new().build_hasher().finish());
        Self { token, worker: Worker::me(), lease, beats: 0, recipe: Some(recipe.to_owned()) }
    }

    /// Whether the claim says that the frame is rendered from something other than `recipe`.
    pub(super) fn is_of_other(&self, recipe: &str) -> bool {
        self.recipe.as_ref().is_some_and(|own| own != recipe)
    }

    /// Returns the shortest silence after which the owner may count as dead: several signs of life
    /// are missing.
    pub(super) fn least_silence(&self) -> Duration {
        const MISSED: u32 = 3;
        period(self.lease) * MISSED
    }

    /// Overwrites the contents of `file` with the claim, and flushes them to the disk or the
    /// server.
    ///
    /// # Errors
    /// Any I/O error.
    pub(super) fn write(&self, file: &mut File) -> io::Result<()> {
        file.rewind()?;
        file.write_all(self.text().as_bytes())?;
        file.sync_data()
    }

    /// Formats the claim for its file. The length never changes.
    fn text(&self) -> String {
        let Self { token, worker: Worker { host, process }, lease, beats, recipe } = self;
        let recipe = recipe.as_deref().unwrap_or_default();
        format!("{token} {:010} {beats:020} {process} {host} {recipe}\n", lease.as_millis())
    }

    /// Reads the claim at `path`.
    ///
    /// # Errors
    /// Any I/O error: there is no file, or there is a folder, a device or a pipe instead.
    pub(super) fn read(path: &Path) -> io::Result<Self> {
        let mut bytes = Vec::new();
        open_regular(path)?.take(MOST).read_to_end(&mut bytes)?;
        Ok(Self::parse(&String::from_utf8_lossy(&bytes)))
    }

    /// Parses a claim. Nothing in a file is trusted: missing or invalid fields are replaced.
    fn parse(text: &str) -> Self {
        let mut fields = text.split_whitespace();
        let token = fields.next().filter(|token| token.len() <= 32);
        let token = token.filter(|token| token.bytes().all(|byte| byte.is_ascii_alphanumeric()));
        let lease = fields.next().and_then(|millis| millis.parse().ok()).unwrap_or(60_000);
        let beats = fields.next().and_then(|beats| beats.parse().ok()).unwrap_or(0);
        let process = fields.next().and_then(|process| process.parse().ok()).unwrap_or(0);
        let worker = Worker { host: shown(fields.next().unwrap_or_default()), process };
        let is_hash = |hash: &&str| hash.len() <= 64 && hash.bytes().all(|b| b.is_ascii_hexdigit());
        let recipe = fields.next().filter(is_hash).map(str::to_owned);
        let lease = Duration::from_millis(lease).clamp(SHORTEST_LEASE, LONGEST_LEASE);
        Self { token: token.unwrap_or(NO_TOKEN).to_owned(), worker, lease, beats, recipe }
    }
}

/// Reads who made the claim at `path`.
///
/// # Errors
/// As [`Note::read`].
pub(crate) fn owner_of(path: &Path) -> io::Result<Worker> {
    Note::read(path).map(|note| note.worker)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let mut note = Note::new(Duration::from_secs(60), "0123456789abcdef");
        let length = note.text().len();
        note.beats = u64::MAX;
        assert_eq!(Note::parse(&note.text()), note);
        assert_eq!(note.text().len(), length);
        assert_ne!(Note::new(note.lease, "").token, note.token);
    }

    #[test]
    fn a_claim_knows_what_it_is_of() {
        let note = Note::new(Duration::from_secs(60), "0a");
        assert!(!note.is_of_other("0a") && note.is_of_other("0b"));
        assert!(!Note::parse("0123 60000 1 4711 anna").is_of_other("0b"), "it does not say");
        assert!(!Note::parse("0123 60000 1 4711 anna x/y").is_of_other("0b"), "no hash");
    }

    #[test]
    fn silence_is_counted_in_signs_of_life() {
        let silence = |seconds| Note::new(Duration::from_secs(seconds), "").least_silence();
        assert_eq!(silence(12), Duration::from_secs(3));
        assert_eq!(silence(60), Duration::from_secs(15));
        assert_eq!(silence(86_400), Duration::from_secs(15), "a day makes nobody wait for a day");
    }

    #[test]
    fn any_file_is_read_and_leads_nowhere() {
        for odd in
            ["", "\n", "../../x 1 2 3 4", "a/b", "0 -1 x y \u{1b}[31mred", "0 99999999999999"]
        {
            let note = Note::parse(odd);
            assert_eq!(note.token, NO_TOKEN, "{odd}");
            assert!(!note.worker.to_string().contains('\u{1b}'), "{odd}");
            assert!(note.lease <= LONGEST_LEASE, "{odd}");
        }
    }
}
