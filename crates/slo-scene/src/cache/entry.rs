//! A file of a cache: a head, then sections of bytes.
//!
//! The head holds, in this order: [`MAGIC`]; the hash of the key; the number of sections; their
//! lengths; a hash for each [`CHUNK`] of each section; a hash of the head so far. Numbers have 8 bytes,
//! the lowest first.

use std::fs::File;
use std::io::{self, Read};
use std::sync::atomic::{AtomicBool, Ordering};

use bytemuck::{Pod, Zeroable, cast_slice_mut};
use rayon::prelude::*;

use super::key::Key;

/// The first bytes; they name the version of this format.
const MAGIC: &[u8; 16] = b"slo-rt cache 1\n\0";

/// Bytes that are read and checked by one task.
const CHUNK: usize = 1 << 21;

/// Most sections of a file.
const MOST_SECTIONS: u64 = 64;

/// Bytes of a hash.
const HASH: usize = 32;

/// The head of a file.
pub(super) fn head(key: &Key, sections: &[&[u8]]) -> Vec<u8> {
    let mut head = MAGIC.to_vec();
    head.extend(key.hash());
    head.extend((sections.len() as u64).to_le_bytes());
    for section in sections {
        head.extend((section.len() as u64).to_le_bytes());
    }
    for section in sections {
        let hashes: Vec<_> = section.par_chunks(CHUNK).map(blake3::hash).collect();
        hashes.iter().for_each(|hash| head.extend(hash.as_bytes()));
    }
    let hash = blake3::hash(&head);
    head.extend(hash.as_bytes());
    head
}

/// A file whose head is sound.
#[derive(Debug)]
pub struct Entry {
    file: File,
    sections: Vec<Section>,
}

#[derive(Debug)]
struct Section {
    length: usize,
    /// Where it begins in the file.
    begin: u64,
    /// One for each chunk.
    hashes: Vec<[u8; HASH]>,
}

impl Entry {
    /// Reads the head of a file. `None` if it is not the file of a key, or not as long as its head
    /// says.
    pub(super) fn open(mut file: File, key: &Key) -> Option<Self> {
        let data = file.metadata().ok().filter(|data| data.is_file())?;
        let size = data.len();
        let mut head = Vec::new();
        let mut more = |bytes: u64| {
            // No more memory than there are bytes in the file.
            let all = bytes.checked_add(head.len() as u64).filter(|all| *all <= size)?;
            let begin = head.len();
            head.resize(usize::try_from(all).ok()?, 0);
            file.read_exact(&mut head[begin..]).ok()?;
            Some(head.clone())
        };
        let fixed = more((MAGIC.len() + HASH + 8) as u64)?;
        let (magic, rest) = fixed.split_at(MAGIC.len());
        let (hash, count) = rest.split_at(HASH);
        let count = u64::from_le_bytes(count.try_into().ok()?);
        if magic != MAGIC || hash != key.hash() || count > MOST_SECTIONS {
            return None;
        }
        let lengths = more(8 * count)?;
        let lengths = lengths[fixed.len()..].chunks_exact(8);
        let lengths: Vec<u64> = lengths
            .map(|bytes| Some(u64::from_le_bytes(bytes.try_into().ok()?)))
            .collect::<Option<_>>()?;
        if lengths.iter().any(|length| *length > size) {
            return None;
        }
        let chunks = |length: u64| length.div_ceil(CHUNK as u64);
        let table = lengths.iter().map(|length| chunks(*length)).sum::<u64>() * HASH as u64;
        let head = more(table + HASH as u64)?;
        let (said, of_head) = head.split_at(head.len() - HASH);
        let all = head.len() as u64 + lengths.iter().sum::<u64>();
        if *blake3::hash(said).as_bytes() != *of_head || all != size {
            return None;
        }
        let hashes = said[said.len() - table as usize..].chunks_exact(HASH);
        let mut hashes = hashes.filter_map(|hash| hash.try_into().ok());
        let mut begin = head.len() as u64;
        let mut sections = Vec::with_capacity(lengths.len());
        for length in lengths {
            let hashes = hashes.by_ref().take(chunks(length) as usize).collect();
            sections.push(Section { length: usize::try_from(length).ok()?, begin, hashes });
            begin += length;
        }
        Some(Self { file, sections })
    }

    /// The length of a section in bytes; `None` if there is no such section.
    pub fn length(&self, section: usize) -> Option<usize> {
        self.sections.get(section).map(|section| section.length)
    }

    /// Fills `to`, which is as long as a section, with its bytes, on all threads of the current pool.
    /// Returns false if they can't be read, or were changed since they were written.
    pub fn read(&self, section: usize, to: &mut [u8]) -> bool {
        let Some(section) = self.sections.get(section) else { return false };
        if to.len() != section.length {
            return false;
        }
        let is_sound = AtomicBool::new(true);
        let chunks = to.par_chunks_mut(CHUNK).zip(&section.hashes).enumerate();
        chunks.for_each(|(number, (chunk, hash))| {
            let offset = section.begin + (number * CHUNK) as u64;
            let is_read =
                is_sound.load(Ordering::Relaxed) && read_at(&self.file, chunk, offset).is_ok();
            if !is_read || blake3::hash(chunk) != *hash {
                is_sound.store(false, Ordering::Relaxed);
            }
        });
        is_sound.into_inner()
    }

    /// Reads a section of values. `None` if it has no whole number of them, or can't be read.
    pub fn values<T: Pod + Zeroable>(&self, section: usize) -> Option<Vec<T>> {
        let length = self.length(section)?;
        if !length.is_multiple_of(size_of::<T>()) {
            return None;
        }
        let mut values = bytemuck::zeroed_vec(length / size_of::<T>());
        self.read(section, cast_slice_mut(&mut values)).then_some(values)
    }
}

/// Fills `to` with the bytes of a file from `offset` on.
#[cfg(unix)]
fn read_at(file: &File, to: &mut [u8], offset: u64) -> io::Result<()> {
    std::os::unix::fs::FileExt::read_exact_at(file, to, offset)
}

/// Fills `to` with the bytes of a file from `offset` on.
#[cfg(windows)]
fn read_at(file: &File, mut to: &mut [u8], mut offset: u64) -> io::Result<()> {
    while !to.is_empty() {
        match std::os::windows::fs::FileExt::seek_read(file, to, offset)? {
            0 => return Err(io::ErrorKind::UnexpectedEof.into()),
            read => {
                to = &mut to[read..];
                offset += read as u64;
            }
        }
    }
    Ok(())
}
