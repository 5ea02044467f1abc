//! Whether a PNG file is as it was written, by the checksums of its chunks.
//!
//! The `png` crate ignores wrong checksums of ancillary chunks, such as the recipe's or `sRGB`, and does
//! not look behind the last chunk.

use std::io::{self, BufRead, ErrorKind, Read};

/// The first bytes of every PNG file.
pub(super) const SIGNATURE: [u8; 8] = *b"\x89PNG\r\n\x1a\n";

/// Reads a PNG file to its end: all chunks are there and match their checksums, and nothing follows the
/// last one.
///
/// # Errors
/// `InvalidData` with what is damaged; what the system says of reading.
pub(super) fn check(file: impl BufRead) -> io::Result<()> {
    scan(file).map(|_| ())
}

/// The same; returns whether the file has the form of our files. Programs that keep the recipe of a
/// picture that they change write other chunks, or cut the pixels into other pieces.
pub(super) fn scan(mut file: impl BufRead) -> io::Result<bool> {
    let mut form = Form::default();
    let mut signature = [0; 8];
    read(&mut file, &mut signature, "its first chunk")?;
    if signature != SIGNATURE {
        return Err(damaged("its first bytes are not those of a PNG file"));
    }
    loop {
        let mut start = [0; 8];
        read(&mut file, &mut start, "its last chunk")?;
        let [length, kind] = [0, 4].map(|at| [0, 1, 2, 3].map(|i| start[at + i]));
        let name = name(kind);
        let mut checksum = crc32fast::Hasher::new();
        checksum.update(&kind);
        let end = format!("the end of {name}");
        hash_bytes(&mut file, u32::from_be_bytes(length), &mut checksum, &end)?;
        let mut expected = [0; 4];
        read(&mut file, &mut expected, &end)?;
        if checksum.finalize() != u32::from_be_bytes(expected) {
            return Err(damaged(format!("the checksum of {name} is wrong")));
        }
        form.add(kind, u32::from_be_bytes(length));
        if kind == *b"IEND" {
            let more = !file.fill_buf()?.is_empty();
            let ended = Err(damaged("there are bytes after its end"));
            return if more { ended } else { Ok(form.is_ours()) };
        }
    }
}

/// The chunks of a file: their kinds, and the lengths of those with pixels.
#[derive(Default)]
struct Form {
    /// Kinds in their order, repeated ones once.
    kinds: Vec<[u8; 4]>,
    /// Lengths of the last chunk of pixels, and of the one before.
    last: [u32; 2],
    /// A chunk of pixels before the last two has another length than ours.
    is_odd: bool,
}

impl Form {
    /// Bytes of pixels in a chunk; the last two may have less.
    const PIECE: u32 = 4096;
    const SHORT: [[u8; 4]; 4] = [*b"IHDR", *b"tEXt", *b"IDAT", *b"IEND"];
    const LONG: [[u8; 4]; 5] = [*b"IHDR", *b"sRGB", *b"tEXt", *b"IDAT", *b"IEND"];

    fn add(&mut self, kind: [u8; 4], length: u32) {
        if kind == *b"IDAT" {
            let [last, before] = self.last;
            self.is_odd |= length > Self::PIECE || (before != 0 && before != Self::PIECE);
            self.last = [length, last];
        }
        if (kind != *b"IDAT" || self.kinds.last() != Some(&kind)) && self.kinds.len() < 8 {
            self.kinds.push(kind);
        }
    }

    fn is_ours(&self) -> bool {
        // The end of the pixels comes in a chunk of its own.
        let is_cut = self.last.iter().all(|&length| length > 0) && !self.is_odd;
        is_cut && (self.kinds == Self::SHORT || self.kinds == Self::LONG)
    }
}

/// The name in a message; a damaged one may not be text.
fn name(kind: [u8; 4]) -> String {
    match str::from_utf8(&kind) {
        Ok(kind) if kind.bytes().all(|byte| byte.is_ascii_alphabetic()) => {
            format!("its {kind} chunk")
        }
        _ => "one of its chunks".into(),
    }
}

fn read(file: &mut impl Read, bytes: &mut [u8], what: &str) -> io::Result<()> {
    file.read_exact(bytes).map_err(|error| match error.kind() {
        ErrorKind::UnexpectedEof => ends_before(what),
        _ => error,
    })
}

/// Adds so many bytes to a checksum.
fn hash_bytes(
    file: &mut impl BufRead,
    length: u32,
    checksum: &mut crc32fast::Hasher,
    what: &str,
) -> io::Result<()> {
    let mut left = length as usize;
    while left > 0 {
        let bytes = file.fill_buf()?;
        if bytes.is_empty() {
            return Err(ends_before(what));
        }
        let taken = bytes.len().min(left);
        checksum.update(&bytes[..taken]);
        file.consume(taken);
        left -= taken;
    }
    Ok(())
}

fn ends_before(what: &str) -> io::Error {
    damaged(format!("it ends before {what}"))
}

fn damaged(why: impl std::fmt::Display) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, format!("it is damaged: {why}"))
}

#[cfg(test)]
mod tests {
    use slo_scene::Look;

    use super::*;
    use crate::output::format::samples::{bytes, sample_image};
    use crate::output::format::{Encoding, OutputFormat, Picture};

    fn told(bytes: &[u8]) -> String {
        check(bytes).unwrap_err().to_string()
    }

    #[test]
    fn every_bit_counts() {
        for format in [OutputFormat::Png8, OutputFormat::Png16] {
            let whole = bytes(format, Encoding::Srgb, &sample_image());
            check(&whole[..]).unwrap();
            for at in 0..whole.len() {
                for bit in 0..8 {
                    let mut damaged = whole.clone();
                    damaged[at] ^= 1 << bit;
                    let why = told(&damaged);
                    assert!(why.starts_with("it is damaged: "), "bit {bit} of byte {at}: {why}");
                    assert!(!why.contains(['{', '\n']) && why.is_ascii(), "byte {at}: {why}");
                }
            }
            for length in 0..whole.len() {
                assert!(told(&whole[..length]).contains("it ends before"), "cut off at {length}");
            }
        }
    }

    #[test]
    fn our_form_is_known_at_any_size() {
        let noise = |i: u32| (i.wrapping_mul(2_654_435_761) >> 7) as f32 / 3e7;
        for (width, height) in [(1, 1), (5, 3), (4000, 1), (1, 4000), (300, 300), (8000, 3)] {
            let rgb = (0..width * height).map(|i| [noise(3 * i), noise(i), 0.5]).collect();
            let image = crate::film::Image { width, height, rgb };
            for format in [OutputFormat::Png8, OutputFormat::Png16] {
                for encoding in [Encoding::Raw, Encoding::Srgb] {
                    let mut out = io::Cursor::new(Vec::new());
                    Picture {
                        image: &image,
                        format,
                        look: Look::of(encoding),
                        recipe: "{}",
                        crop: None,
                    }
                    .write(&mut out)
                    .unwrap();
                    assert!(scan(&out.into_inner()[..]).unwrap(), "{width}x{height} {format:?}");
                }
            }
        }
    }

    #[test]
    fn it_says_what_is_damaged() {
        let whole = bytes(OutputFormat::Png8, Encoding::Srgb, &sample_image());
        let chunk = |name: &[u8; 4]| whole.windows(4).position(|found| found == name).unwrap();
        let flipped = |at: usize, bits: u8| {
            let mut damaged = whole.clone();
            damaged[at] ^= bits;
            told(&damaged)
        };
        let check = |found: String, expected: &str| {
            assert_eq!(found, format!("it is damaged: {expected}"));
        };
        check(flipped(chunk(b"sRGB") + 4, 1), "the checksum of its sRGB chunk is wrong");
        check(flipped(chunk(b"tEXt") + 20, 1), "the checksum of its tEXt chunk is wrong");
        check(flipped(chunk(b"tEXt") - 1, 1), "the checksum of its tEXt chunk is wrong");
        check(flipped(chunk(b"tEXt"), 0x80), "the checksum of one of its chunks is wrong");
        check(flipped(chunk(b"IDAT") - 4, 1), "it ends before the end of its IDAT chunk");
        check(told(&whole[..whole.len() - 13]), "it ends before the end of its IDAT chunk");
        check(told(&whole[..whole.len() - 12]), "it ends before its last chunk");
        check(flipped(0, 1), "its first bytes are not those of a PNG file");
        check(told(&[&whole[..], b"x"].concat()), "there are bytes after its end");
    }
}
