//! What a file of a cache is named by.

use rayon::prelude::*;

/// Bytes that one task hashes.
const TASK: usize = 1 << 20;

/// A name made of everything that a content is worked out from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key {
    kind: &'static str,
    hash: [u8; 32],
}

impl Key {
    /// The key of a content of a kind, from all that determines it. `layout` is the version of the
    /// content's layout and of the way it is worked out; the version of the crate counts too.
    pub fn new(kind: &'static str, layout: u32, parts: &[&[u8]]) -> Self {
        let mut hasher = blake3::Hasher::new();
        let version = env!("CARGO_PKG_VERSION").as_bytes();
        let fixed: [&[u8]; 3] = [kind.as_bytes(), version, &layout.to_le_bytes()];
        for part in fixed.iter().chain(parts) {
            hasher.update(&(part.len() as u64).to_le_bytes());
            hasher.update(part);
        }
        Self { kind, hash: *hasher.finalize().as_bytes() }
    }

    pub(super) fn hash(&self) -> &[u8; 32] {
        &self.hash
    }

    /// The name of the file, without what all names have in common.
    pub(super) fn name(&self) -> String {
        format!("{}-{}", self.kind, &blake3::Hash::from(self.hash).to_hex()[..32])
    }
}

/// A hash of many bytes, computed by all threads of the current pool.
pub fn hash_of(bytes: &[u8]) -> [u8; 32] {
    let parts: Vec<_> = bytes.par_chunks(TASK).map(blake3::hash).collect();
    let mut hasher = blake3::Hasher::new();
    hasher.update(&(bytes.len() as u64).to_le_bytes());
    for part in parts {
        hasher.update(part.as_bytes());
    }
    *hasher.finalize().as_bytes()
}
