//! Whether a picture that is there is the one that would be rendered.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek};
use std::path::Path;

use super::file::open_regular;
use super::recipe::{RecipeError, read_recipe, steps_of, with_steps};
use super::seal::{self, Seal};
use super::{read_state, without_outcome};
use crate::film::Subject;

/// What lies under a picture's name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Found {
    /// The picture, whole, with the recipe that was looked for.
    Finished,
    /// Nothing.
    Missing,
    /// A picture that was cut off or changed, or no picture.
    Damaged,
    /// A picture of another recipe: the first line that differs, as it is there.
    Stale(String),
}

/// Looks for the picture with `recipe` at `path`. Reads all of a picture with that recipe, and checks
/// the checksums of its file.
pub fn find_picture(path: &Path, recipe: &str) -> Found {
    let found = match read_recipe(path) {
        Ok(found) => without_outcome(&found),
        Err(RecipeError::Io(error)) if error.kind() == io::ErrorKind::NotFound => {
            return Found::Missing;
        }
        Err(RecipeError::NoRecipe) => return Found::Stale("no recipe of slo-rt".into()),
        Err(_) => return Found::Damaged,
    };
    if found != recipe {
        Found::Stale(first_difference(&found, recipe))
    } else if open_regular(path).and_then(is_whole).unwrap_or(false) {
        Found::Finished
    } else {
        Found::Damaged
    }
}

/// The same for a picture that was given a span of time: whatever steps it came to.
pub fn find_timed_picture(path: &Path, recipe: &str) -> Found {
    let found = read_recipe(path).ok().map(|found| without_outcome(&found));
    let parsed = found.as_ref().and_then(|found| serde_json::from_str(found).ok());
    match parsed.and_then(|parsed| steps_of(&parsed)) {
        Some(steps) => find_picture(path, &with_steps(recipe.to_owned(), steps)),
        None => match find_picture(path, recipe) {
            // The same, but not step by step.
            Found::Finished => Found::Stale("without a span of time".into()),
            other => other,
        },
    }
}

/// Looks for a complete state of `subject` at `path`. Reads all of it.
pub fn find_state(path: &Path, subject: &Subject) -> Found {
    match read_state(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Found::Missing,
        Err(_) => Found::Damaged,
        Ok(state) if !state.is_complete => Found::Damaged,
        Ok(state) if state.subject == *subject => Found::Finished,
        Ok(state) => Found::Stale(first_difference(&state.subject.recipe, &subject.recipe)),
    }
}

/// The first member of `found` that is not in `recipe`.
fn first_difference(found: &str, recipe: &str) -> String {
    let expected: Vec<&str> = members(recipe).collect();
    let other = members(found).find(|member| !expected.contains(member));
    other.unwrap_or("a setting less").replace('"', "")
}

/// The members of a recipe, a line each; the last one has no comma.
fn members(recipe: &str) -> impl Iterator<Item = &str> {
    recipe.lines().map(|line| line.trim().trim_end_matches(','))
}

/// Whether a PNG or EXR file is the one that was written, to the last bit.
fn is_whole(mut file: File) -> io::Result<bool> {
    let mut magic = [0; 4];
    file.read_exact(&mut magic)?;
    file.rewind()?;
    if magic == [0x89, b'P', b'N', b'G'] {
        png_is_whole(BufReader::with_capacity(1 << 17, file))
    } else {
        Ok(seal::look(file)? == Seal::Whole)
    }
}

/// Whether the chunks up to the last have the checksums that they say, and nothing follows them.
fn png_is_whole(mut file: impl BufRead) -> io::Result<bool> {
    let mut signature = [0; 8];
    file.read_exact(&mut signature)?;
    if signature != *b"\x89PNG\r\n\x1a\n" {
        return Ok(false);
    }
    loop {
        let mut start = [0; 8];
        file.read_exact(&mut start)?;
        let [length, kind] = [0, 4].map(|at| [0, 1, 2, 3].map(|i| start[at + i]));
        let mut checksum = crc32fast::Hasher::new();
        checksum.update(&kind);
        let is_there = hash_bytes(&mut file, u32::from_be_bytes(length), &mut checksum)?;
        let mut expected = [0; 4];
        file.read_exact(&mut expected)?;
        if !is_there || checksum.finalize() != u32::from_be_bytes(expected) {
            return Ok(false);
        }
        if kind == *b"IEND" {
            return Ok(file.fill_buf()?.is_empty());
        }
    }
}

/// Takes so many bytes to a checksum; whether there were as many.
fn hash_bytes(
    file: &mut impl BufRead,
    length: u32,
    checksum: &mut crc32fast::Hasher,
) -> io::Result<bool> {
    let mut left = length as usize;
    while left > 0 {
        let bytes = file.fill_buf()?;
        if bytes.is_empty() {
            return Ok(false);
        }
        let taken = bytes.len().min(left);
        checksum.update(&bytes[..taken]);
        file.consume(taken);
        left -= taken;
    }
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::super::{Picture, tests::sample_image};
    use super::*;
    use crate::scene::{Encoding, OutputFormat};

    const RECIPE: &str = "{\n  \"frame\": 5,\n  \"seed\": 1\n}";

    #[test]
    fn a_member_at_the_end_is_no_difference() {
        let longer = RECIPE.replace("\n}", ",\n  \"steps\": [7, 120]\n}");
        assert_eq!(first_difference(&longer, RECIPE), "steps: [7, 120]");
        assert_eq!(first_difference(RECIPE, &longer), "a setting less");
    }

    #[test]
    fn finished_missing_damaged_and_stale_are_told_apart() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture");
        for format in [OutputFormat::Png8, OutputFormat::Png16, OutputFormat::Exr] {
            let image = sample_image();
            let encoding = Encoding::Raw;
            let picture = Picture { image: &image, format, encoding, recipe: RECIPE, crop: None };
            picture.save(&path).unwrap();
            assert_eq!(find_picture(&path, RECIPE), Found::Finished, "{format:?}");
            let other = RECIPE.replace("1", "2");
            assert_eq!(find_picture(&path, &other), Found::Stale("seed: 1".into()));
            let fewer = RECIPE.replace(",\n  \"seed\": 1", "");
            assert_eq!(find_picture(&path, &fewer), Found::Stale("seed: 1".into()));
            let whole = std::fs::read(&path).unwrap();
            for length in 0..whole.len() {
                std::fs::write(&path, &whole[..length]).unwrap();
                assert_eq!(find_picture(&path, RECIPE), Found::Damaged, "{format:?} {length}");
            }
            for at in 0..whole.len() {
                let mut flipped = whole.clone();
                flipped[at] ^= 4;
                let mut zeroed = whole.clone();
                let end = (at + 16).min(whole.len());
                zeroed[at..end].fill(0);
                for damaged in [flipped, zeroed].iter().filter(|bytes| **bytes != whole) {
                    std::fs::write(&path, damaged).unwrap();
                    let found = find_picture(&path, RECIPE);
                    assert_ne!(found, Found::Finished, "{format:?} {at}");
                }
            }
            std::fs::write(&path, [&whole[..], b"more"].concat()).unwrap();
            assert_eq!(find_picture(&path, RECIPE), Found::Damaged, "{format:?}");
            std::fs::remove_file(&path).unwrap();
            assert_eq!(find_picture(&path, RECIPE), Found::Missing);
        }
    }
}
