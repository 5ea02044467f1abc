//! Corners of faces: `v`, `v/vt`, `v//vn`, `v/vt/vn`.

use crate::format::{FileError, Place};

/// What indices can refer to, in the order of a corner's parts.
const KINDS: [&str; 3] = ["vertex", "uv", "normal"];

/// Their plurals.
const PLURALS: [&str; 3] = ["vertices", "uvs", "normals"];

/// Indices of vertex, uv and normal, from 1; 0 if there is none.
pub(super) type Corner = [u32; 3];

/// A reference to something that is not defined (yet).
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Missing {
    /// Of vertices, uvs or normals: 0, 1, 2.
    pub(super) kind: usize,
    /// Index from 1; 0 if it lies in front of the first one.
    index: u64,
    message: String,
}

/// The corner that a word describes, and its references to what is not defined so far. Negative
/// indices count back from the last of the `counts` vertices, uvs and normals.
///
/// # Errors
/// What is wrong with the word.
pub(super) fn parse_corner(word: &str, counts: [u64; 3]) -> Result<(Corner, Vec<Missing>), String> {
    let mut corner = [0; 3];
    let mut missing = Vec::new();
    for (kind, part) in word.split('/').enumerate() {
        if kind == 3 {
            return Err(format!("`{word}` has more parts than vertex/uv/normal"));
        }
        if kind == 0 || !part.is_empty() {
            let (index, fault) = parse_index(part, counts[kind], kind)?;
            corner[kind] = index;
            missing.extend(fault);
        }
    }
    Ok((corner, missing))
}

/// An index of a kind, from 1.
fn parse_index(part: &str, count: u64, kind: usize) -> Result<(u32, Option<Missing>), String> {
    let name = KINDS[kind];
    let index = match part.parse::<i64>() {
        Err(_) => return Err(format!("`{part}` is not the index of a {name}")),
        Ok(0) => return Err(format!("there is no {name} 0, the first one is 1")),
        Ok(index) => index,
    };
    if index < 0 {
        return Ok(match count.checked_sub(index.unsigned_abs()) {
            Some(before) => (narrow(before + 1), None),
            None => {
                let so_far = there_are(count, kind);
                let message = format!("{name} {index} is too far back: {so_far} so far");
                // Any index: the file is refused, or has none of this kind.
                (1, Some(Missing { kind, index: 0, message }))
            }
        });
    }
    let index = index.unsigned_abs();
    let missing = (index > count).then(|| Missing { kind, index, message: String::new() });
    Ok((narrow(index), missing))
}

/// The index in 32 bits; more vertices than that are refused.
fn narrow(index: u64) -> u32 {
    index.try_into().unwrap_or(u32::MAX)
}

/// "there are 8 vertices"
fn there_are(count: u64, kind: usize) -> String {
    match count {
        0 => format!("there are no {}", PLURALS[kind]),
        1 => format!("there is 1 {}", KINDS[kind]),
        _ => format!("there are {count} {}", PLURALS[kind]),
    }
}

/// The references of a file to what was not defined yet when they were read.
#[derive(Debug, Default)]
pub(super) struct References {
    /// Of each kind the first one that counts back too far.
    behind: [Option<FileError>; 3],
    /// Of each kind the largest index that was not defined yet.
    ahead: [Option<(u64, Place)>; 3],
}

impl References {
    /// Takes note of the references of one face; `place` gives the place of a corner's references.
    ///
    /// A place costs as much as the line is long, so there is one for each kind at most.
    pub(super) fn note<'m>(
        &mut self,
        missing: impl Iterator<Item = (&'m Missing, usize)>,
        place: impl Fn(usize) -> Place,
    ) {
        let mut ahead = [None; 3];
        for (&Missing { kind, index, ref message }, corner) in missing {
            let known = self.ahead[kind].as_ref().map_or(0, |(largest, _)| *largest);
            let known = ahead[kind].map_or(known, |(largest, _)| largest);
            if index == 0 {
                self.behind[kind].get_or_insert_with(|| place(corner).error(message.clone(), ""));
            } else if index > known {
                ahead[kind] = Some((index, corner));
            }
        }
        for (slot, ahead) in self.ahead.iter_mut().zip(ahead) {
            if let Some((index, corner)) = ahead {
                *slot = Some((index, place(corner)));
            }
        }
    }

    /// Refuses references to what is still not defined at the end of the file. Uvs and normals of a
    /// file that has none at all may be referred to: the place of one such reference, by kind.
    ///
    /// # Errors
    /// The first reference to something that does not exist.
    pub(super) fn check(self, counts: [u64; 3]) -> Result<[Option<usize>; 3], FileError> {
        let mut to_nothing = [None; 3];
        for (kind, (behind, ahead)) in self.behind.into_iter().zip(self.ahead).enumerate() {
            let count = counts[kind];
            let ahead = ahead.filter(|(index, _)| *index > count).map(|(index, place)| {
                let there_are = there_are(count, kind);
                let message = format!("a face refers to {} {index}, but {there_are}", KINDS[kind]);
                place.error(message, "out of range")
            });
            match behind.or(ahead) {
                Some(error) if kind > 0 && count == 0 => to_nothing[kind] = Some(error.line),
                Some(error) => return Err(error),
                None => {}
            }
        }
        Ok(to_nothing)
    }
}
