//! Files that other processes leave beside pictures, read by themselves: for fuzzing.

use std::path::Path;

use super::claims;
use super::commands::render;

/// Reads a claim on a frame, and returns it as messages show its owner.
pub fn read_claim(path: &Path) -> Option<String> {
    claims::owner_of(path).ok().map(|worker| worker.to_string())
}

/// Reads a ledger of times; returns how many frames it knows.
pub fn read_ledger(path: &Path) -> usize {
    render::frames_of_ledger(path)
}
