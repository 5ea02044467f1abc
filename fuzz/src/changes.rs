//! Random changes of an input.

use rand::rngs::StdRng;
use rand::{Rng, RngExt};

/// Longest piece that is taken out or put in.
const LONGEST: usize = 64;

/// Pieces that readers may stumble over, of text and of binary files.
const ODD: [&[u8]; 12] = [
    b"0",
    b"-1",
    b"1e400",
    b"nan",
    b"4294967295",
    b"9223372036854775808",
    b"{",
    b"}",
    b"\n",
    b"\xff\xff\xff\xff",
    b"\x80\0\0\0",
    b"\0\0\0\x80",
];

/// An input with one to four changes: bytes are replaced, taken out, repeated, or taken from another input.
pub fn changed(rng: &mut StdRng, input: &[u8], other: &[u8]) -> Vec<u8> {
    let mut data = input.to_vec();
    for _ in 0..rng.random_range(1..5) {
        let at = rng.random_range(0..=data.len());
        let end = data.len().min(at + rng.random_range(0..=LONGEST));
        match rng.random_range(0..6) {
            0 => drop(data.drain(at..end)),
            1 => {
                let again = data[at..end].to_vec();
                data.splice(at..at, again);
            }
            2 => {
                let piece = ODD[rng.random_range(0..ODD.len())];
                data.splice(at..end.min(at + piece.len()), piece.iter().copied());
            }
            3 => {
                let from = rng.random_range(0..=other.len());
                let to = other.len().min(from + rng.random_range(0..=LONGEST));
                data.splice(at..end, other[from..to].iter().copied());
            }
            4 => rng.fill_bytes(&mut data[at..end.min(at + 4)]),
            _ => {
                if let Some(byte) = data.get_mut(at) {
                    *byte ^= 1 << rng.random_range(0..8);
                }
            }
        }
    }
    data
}
