//! Corners of faces: `v`, `v/vt`, `v//vn`, `v/vt/vn`.

use crate::format::{FileError, Place};

/// What indices can refer to, in the order of a corner's parts.
const KINDS: [&str; 3] = ["vertex", "uv", "normal"];

/// Their plurals.
const PLURALS: [&str; 3] = ["vertices", "uvs", "normals"];

/// Indices of vertex, uv and normal, from 1; 0 where there is none.
pub(super) type Corner = [u64; 3];

/// The corner that a word describes. Negative indices count back from the last of the `counts`
/// vertices, uvs and normals so far.
///
/// # Errors
/// What is wrong with the word.
pub(super) fn parse_corner(word: &str, counts: [u64; 3]) -> Result<Corner, String> {
    let mut corner = [0; 3];
    for (kind, part) in word.split('/').enumerate() {
        if kind == 3 {
            return Err(format!("`{word}` has more parts than vertex/uv/normal"));
        }
        if kind == 0 || !part.is_empty() {
            corner[kind] = parse_index(part, counts[kind], kind)?;
        }
    }
    Ok(corner)
}

/// An index of a kind, from 1.
fn parse_index(part: &str, count: u64, kind: usize) -> Result<u64, String> {
    let name = KINDS[kind];
    match part.parse::<i64>() {
        Err(_) => Err(format!("`{part}` is not the index of a {name}")),
        Ok(0) => Err(format!("there is no {name} 0, the first one is 1")),
        Ok(index @ 1..) => Ok(index.unsigned_abs()),
        Ok(index) => match count.checked_sub(index.unsigned_abs()) {
            Some(before) => Ok(before + 1),
            None => {
                Err(format!("{name} {index} is too far back: {} so far", there_are(count, kind)))
            }
        },
    }
}

/// "there are 8 vertices"
fn there_are(count: u64, kind: usize) -> String {
    match count {
        0 => format!("there are no {}", PLURALS[kind]),
        1 => format!("there is 1 {}", KINDS[kind]),
        _ => format!("there are {count} {}", PLURALS[kind]),
    }
}

/// The largest index of a kind that was not there yet when it was read.
#[derive(Clone, Debug)]
pub(super) struct Forward {
    pub(super) index: u64,
    pub(super) kind: usize,
    pub(super) place: Place,
}

impl Forward {
    /// Refuses the index if the file ends with fewer than that.
    pub(super) fn check(&self, counts: [u64; 3]) -> Result<(), FileError> {
        let (index, kind, count) = (self.index, self.kind, counts[self.kind]);
        if index <= count {
            return Ok(());
        }
        let there_are = there_are(count, kind);
        let message = format!("a face refers to {} {index}, but {there_are}", KINDS[kind]);
        Err(self.place.clone().error(message, "out of range"))
    }
}
