//! The hash of an EXR file inside the file, since OpenEXR has no checksums of its own.
//!
//! An attribute holds BLAKE3 of all bytes of the file, with zeros instead of the hash.

use std::io::{self, Read, Seek, SeekFrom, Write};

/// Name of the attribute.
pub(super) const KEYWORD: &str = "slo-rt blake3";
/// What the names of the attributes of masks begin with. They come last, since they may be long.
pub(super) const MASKS: &[u8] = b"cryptomatte/";
/// What stands there while the file is hashed.
pub(super) const BLANK: &str = "0000000000000000000000000000000000000000000000000000000000000000";
/// Bytes that are read at a time. No header is longer without the attributes of masks.
const PIECE: usize = 1 << 18;

/// What the hash inside a file says of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Seal {
    /// There is none.
    None,
    /// It fits the file.
    Whole,
    /// It does not fit the file.
    Broken,
}

/// Replaces [`BLANK`] with the hash.
pub(super) fn seal(mut file: impl Read + Write + Seek) -> io::Result<()> {
    let Some(hashed) = hash(&mut file)? else { return Err(io::ErrorKind::InvalidData.into()) };
    file.seek(SeekFrom::Start(hashed.at as u64))?;
    file.write_all(hashed.hash.to_hex().as_bytes())
}

/// Reads a file to its end and compares its hash with the hash inside.
pub(super) fn look(file: impl Read + Seek) -> io::Result<Seal> {
    Ok(match hash(file)? {
        None => Seal::None,
        Some(hashed) if hashed.hash.to_hex().as_bytes() == hashed.found => Seal::Whole,
        Some(_) => Seal::Broken,
    })
}

struct Hashed {
    /// Where the hash stands.
    at: usize,
    /// What stands there.
    found: [u8; BLANK.len()],
    hash: blake3::Hash,
}

fn hash(mut file: impl Read + Seek) -> io::Result<Option<Hashed>> {
    file.rewind()?;
    let mut piece = Vec::with_capacity(PIECE);
    let mut next = |piece: &mut Vec<u8>| {
        piece.clear();
        Read::take(&mut file, PIECE as u64).read_to_end(piece)
    };
    next(&mut piece)?;
    let Some(at) = place(&piece) else { return Ok(None) };
    let mut found = [0; BLANK.len()];
    found.copy_from_slice(&piece[at..at + BLANK.len()]);
    piece[at..at + BLANK.len()].copy_from_slice(BLANK.as_bytes());
    let mut hasher = blake3::Hasher::new();
    while !piece.is_empty() {
        hasher.update(&piece);
        next(&mut piece)?;
    }
    Ok(Some(Hashed { at, found, hash: hasher.finalize() }))
}

/// The names of a file's attributes, in their order; `None` if its header is broken.
pub(super) fn names(mut file: impl Read + Seek) -> io::Result<Option<Vec<Vec<u8>>>> {
    file.rewind()?;
    let mut start = Vec::with_capacity(PIECE);
    Read::take(&mut file, PIECE as u64).read_to_end(&mut start)?;
    let mut attributes = Attributes::of(&start);
    let names = attributes.by_ref().map(|(name, _)| name.to_owned()).collect();
    Ok(Some(names).filter(|_| attributes.is_whole))
}

/// Whether a file ends before its header does.
pub(super) fn ends_in_header(start: &[u8]) -> bool {
    let mut attributes = Attributes::of(start);
    attributes.by_ref().for_each(drop);
    !attributes.is_whole
}

/// Where the value of our attribute begins in the first bytes of an EXR file.
fn place(start: &[u8]) -> Option<usize> {
    let (_, value) = Attributes::of(start).find(|(name, _)| *name == KEYWORD.as_bytes())?;
    Some(value.start).filter(|_| value.len() == BLANK.len() && start.len() >= value.end)
}

/// Names of attributes and places of their values. After magic number and version come attributes of
/// name, type, length and value; an empty name ends them.
pub(super) struct Attributes<'a> {
    start: &'a [u8],
    /// Where the next one begins.
    pub(super) at: usize,
    /// The empty name was found.
    pub(super) is_whole: bool,
}

impl<'a> Attributes<'a> {
    pub(super) fn of(start: &'a [u8]) -> Self {
        Self { start, at: 8, is_whole: false }
    }

    fn text(&self, from: usize) -> Option<(&'a [u8], usize)> {
        let length = self.start.get(from..)?.iter().position(|&byte| byte == 0)?;
        Some((&self.start[from..from + length], from + length + 1))
    }
}

impl<'a> Iterator for Attributes<'a> {
    type Item = (&'a [u8], std::ops::Range<usize>);

    fn next(&mut self) -> Option<Self::Item> {
        let (name, behind) = self.text(self.at)?;
        self.is_whole |= name.is_empty();
        let (_, behind) = self.text(behind).filter(|_| !name.is_empty())?;
        let length = u32::from_le_bytes(*self.start.get(behind..)?.first_chunk()?) as usize;
        let value = behind + 4;
        self.at = value.checked_add(length)?;
        Some((name, value..self.at))
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;
    use crate::output::format::samples::{bytes, sample_image};
    use crate::output::format::{Encoding, OutputFormat};

    #[test]
    fn every_byte_counts() {
        let whole = bytes(OutputFormat::Exr, Encoding::Raw, &sample_image());
        let look = |bytes: &[u8]| look(Cursor::new(bytes)).unwrap();
        assert_eq!(look(&whole), Seal::Whole);
        for at in 0..whole.len() {
            let mut damaged = whole.clone();
            damaged[at] ^= 0x20;
            assert_ne!(look(&damaged), Seal::Whole, "byte {at}");
        }
        assert_eq!(look(&[&whole[..], &[0]].concat()), Seal::Broken, "a byte more");
        for length in 0..whole.len() {
            assert_ne!(look(&whole[..length]), Seal::Whole, "cut off at {length}");
        }
    }

    #[test]
    fn files_of_others_have_none() {
        for bytes in [&b""[..], b"\x76\x2f\x31\x01\x02\0\0\0", &[255; 100], &[0; 100], &[1; 9]] {
            assert_eq!(look(Cursor::new(bytes)).unwrap(), Seal::None);
        }
    }
}
