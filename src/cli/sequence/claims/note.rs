//! What stands in a claim.

use std::collections::hash_map::RandomState;
use std::fmt;
use std::fs::File;
use std::hash::{BuildHasher, Hasher};
use std::io::{self, Read, Seek, Write};
use std::path::Path;
use std::process;
use std::time::Duration;

/// Longer than any claim.
const MOST: u64 = 512;
/// Characters of a host's name that are shown.
const LONGEST_HOST: usize = 64;
/// The token of a claim that has none: its owner died between making and filling it.
const NO_TOKEN: &str = "0";

/// A process that renders frames, as people know it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::cli) struct Worker {
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

/// A host's name without what a terminal would take for a command.
fn shown(host: &str) -> String {
    let plain = host.trim().chars().filter(|c| !c.is_control() && !c.is_whitespace());
    let host: String = plain.take(LONGEST_HOST).collect();
    if host.is_empty() { "another machine".into() } else { host }
}

/// A claim as read: whose it is, and what its owner promises.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Note {
    /// No two claims have the same, whoever makes them.
    pub(super) token: String,
    pub(super) worker: Worker,
    /// How long the owner lets pass at most without changing the claim.
    pub(super) lease: Duration,
    /// How often it was changed.
    pub(super) beats: u64,
}

impl Note {
    /// A claim of this process.
    pub(super) fn new(lease: Duration) -> Self {
        let token = format!("{:016x}", RandomState::new().build_hasher().finish());
        Self { token, worker: Worker::me(), lease, beats: 0 }
    }

    /// Writes it over what `file` holds, out to the server where there is one.
    ///
    /// # Errors
    /// What the system says.
    pub(super) fn write(&self, file: &mut File) -> io::Result<()> {
        file.rewind()?;
        file.write_all(self.text().as_bytes())?;
        file.sync_data()
    }

    /// As it stands in the file: of the same length at all times.
    fn text(&self) -> String {
        let Self { token, worker: Worker { host, process }, lease, beats } = self;
        format!("{token} {:010} {beats:020} {process} {host}\n", lease.as_millis())
    }

    /// Reads the claim at `path`.
    ///
    /// # Errors
    /// What the system says: there is none.
    pub(super) fn read(path: &Path) -> io::Result<Self> {
        let mut bytes = Vec::new();
        File::open(path)?.take(MOST).read_to_end(&mut bytes)?;
        Ok(Self::parse(&String::from_utf8_lossy(&bytes)))
    }

    /// Nothing in a file is trusted: what is missing or odd is replaced.
    fn parse(text: &str) -> Self {
        let mut fields = text.split_whitespace();
        let token = fields.next().filter(|token| token.len() <= 32);
        let token = token.filter(|token| token.bytes().all(|byte| byte.is_ascii_alphanumeric()));
        let lease = fields.next().and_then(|millis| millis.parse().ok()).unwrap_or(60_000);
        let beats = fields.next().and_then(|beats| beats.parse().ok()).unwrap_or(0);
        let process = fields.next().and_then(|process| process.parse().ok()).unwrap_or(0);
        let worker = Worker { host: shown(fields.next().unwrap_or_default()), process };
        let lease = Duration::from_millis(lease).clamp(super::SHORTEST_LEASE, super::LONGEST_LEASE);
        Self { token: token.unwrap_or(NO_TOKEN).to_owned(), worker, lease, beats }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let mut note = Note::new(Duration::from_secs(60));
        let length = note.text().len();
        note.beats = u64::MAX;
        assert_eq!(Note::parse(&note.text()), note);
        assert_eq!(note.text().len(), length);
        assert_ne!(Note::new(note.lease).token, note.token);
    }

    #[test]
    fn any_file_is_read_and_leads_nowhere() {
        for odd in
            ["", "\n", "../../x 1 2 3 4", "a/b", "0 -1 x y \u{1b}[31mred", "0 99999999999999"]
        {
            let note = Note::parse(odd);
            assert_eq!(note.token, NO_TOKEN, "{odd}");
            assert!(!note.worker.to_string().contains('\u{1b}'), "{odd}");
            assert!(note.lease <= super::super::LONGEST_LEASE, "{odd}");
        }
    }
}
