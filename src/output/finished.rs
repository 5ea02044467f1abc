//! Whether a picture that is there is the one that would be rendered.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use super::file::open_regular;
use super::recipe::{RecipeError, read_recipe, steps_of, with_steps};
use super::{read_state, without_outcome};
use crate::film::Subject;

/// What lies under a picture's name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Found {
    /// The picture, whole, with the recipe that was looked for.
    Finished,
    /// Nothing.
    Missing,
    /// A picture that was cut off, or no picture.
    Damaged,
    /// A whole picture of another recipe: the first line that differs, as it is there.
    Stale(String),
}

/// Looks for the picture with `recipe` at `path`. Reads the file's beginning and its end: time does
/// not depend on the picture's size.
pub fn find_picture(path: &Path, recipe: &str) -> Found {
    let found = match read_recipe(path) {
        Ok(found) => without_outcome(&found),
        Err(RecipeError::Io(error)) if error.kind() == io::ErrorKind::NotFound => {
            return Found::Missing;
        }
        Err(RecipeError::NoRecipe) => return Found::Stale("no recipe of slo-rt".into()),
        Err(_) => return Found::Damaged,
    };
    if !open_regular(path).and_then(is_whole).unwrap_or(false) {
        Found::Damaged
    } else if found == recipe {
        Found::Finished
    } else {
        Found::Stale(first_difference(&found, recipe))
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

/// Whether a PNG or EXR file ends where its own beginning says, or its format.
fn is_whole(mut file: File) -> io::Result<bool> {
    let mut magic = [0; 4];
    file.read_exact(&mut magic)?;
    file.rewind()?;
    if magic == [0x89, b'P', b'N', b'G'] { png_is_whole(file) } else { exr_is_whole(file) }
}

fn png_is_whole(mut file: File) -> io::Result<bool> {
    const END: [u8; 12] = [0, 0, 0, 0, b'I', b'E', b'N', b'D', 0xae, 0x42, 0x60, 0x82];
    let mut end = [0; 12];
    file.seek(SeekFrom::End(-12))?;
    file.read_exact(&mut end)?;
    Ok(end == END)
}

/// The file ends where the last of its blocks does. A file of one part with scan lines, as ours.
fn exr_is_whole(file: File) -> io::Result<bool> {
    let length = file.metadata()?.len();
    let mut file = BufReader::new(file);
    skip_header(&mut file)?;
    // The table of offsets ends where the first block begins.
    let first = read_u64(&mut file)?;
    let table = file.stream_position()? - 8;
    let blocks = first.saturating_sub(table) / 8;
    let mut last = first;
    for _ in 1..blocks.min(length / 8) {
        last = last.max(read_u64(&mut file)?);
    }
    file.seek(SeekFrom::Start(last))?;
    let _row = read_u32(&mut file)?;
    let bytes = read_u32(&mut file)?;
    Ok(blocks > 0 && last.checked_add(8 + u64::from(bytes)) == Some(length))
}

/// Goes past magic number, version, and the attributes up to the empty name.
fn skip_header(file: &mut BufReader<File>) -> io::Result<()> {
    file.seek(SeekFrom::Start(8))?;
    while !read_text(file)?.is_empty() {
        read_text(file)?;
        let bytes = read_u32(file)?;
        file.seek_relative(i64::from(bytes))?;
    }
    Ok(())
}

/// The bytes up to the next 0.
fn read_text(file: &mut BufReader<File>) -> io::Result<Vec<u8>> {
    let mut text = Vec::new();
    Read::take(file, 256).read_until(0, &mut text)?;
    match text.pop() {
        Some(0) => Ok(text),
        _ => Err(io::ErrorKind::InvalidData.into()),
    }
}

fn read_u32(file: &mut impl Read) -> io::Result<u32> {
    let mut bytes = [0; 4];
    file.read_exact(&mut bytes)?;
    Ok(u32::from_le_bytes(bytes))
}

fn read_u64(file: &mut impl Read) -> io::Result<u64> {
    let mut bytes = [0; 8];
    file.read_exact(&mut bytes)?;
    Ok(u64::from_le_bytes(bytes))
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
            let picture =
                Picture { image: &image, format, encoding: Encoding::Raw, recipe: RECIPE };
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
            std::fs::remove_file(&path).unwrap();
            assert_eq!(find_picture(&path, RECIPE), Found::Missing);
        }
    }
}
