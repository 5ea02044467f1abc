//! Whether an existing picture is the one that would be rendered.

use std::io;
use std::path::Path;

use super::origin::{RESAVED, made_by_others, unless_ours};
use crate::film::Subject;
use crate::output::format::{RecipeError, Wholeness, read_checked, read_recipe};
use crate::output::recipe::{steps_of, with_steps, without_outcome};
use crate::output::state::read_state;

/// The file with a picture's name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Found {
    /// The complete picture, with the expected recipe.
    Finished,
    /// Nothing.
    Missing,
    /// A picture that was truncated or changed, or a file without content.
    Damaged,
    /// A file of another program, or a picture that another program has changed: the reason to think so.
    Foreign(String),
    /// A picture with another recipe: its first line that differs.
    Stale(String),
}

/// Looks for the picture with `recipe` at `path`. Reads the whole file and checks its checksums.
pub fn find_picture(path: &Path, recipe: &str) -> Found {
    let found = match read_checked(path) {
        Ok((_, Wholeness::Resaved)) => return Found::Foreign(RESAVED.into()),
        Ok((found, Wholeness::Whole)) => without_outcome(&found),
        Err(RecipeError::Io(error)) if error.kind() == io::ErrorKind::NotFound => {
            return Found::Missing;
        }
        Err(error) => return unless_ours(path, &error).map_or(Found::Damaged, Found::Foreign),
    };
    match found == recipe {
        true => Found::Finished,
        false => Found::Stale(first_difference(&found, recipe)),
    }
}

/// The same for a picture with a time limit, whatever step it reached.
pub fn find_timed_picture(path: &Path, recipe: &str) -> Found {
    let found = read_recipe(path).ok().map(|found| without_outcome(&found));
    let parsed = found.as_ref().and_then(|found| serde_json::from_str(found).ok());
    match parsed.and_then(|parsed| steps_of(&parsed)) {
        Some(steps) => find_picture(path, &with_steps(recipe.to_owned(), steps)),
        None => match find_picture(path, recipe) {
            // The same recipe, but without steps.
            Found::Finished => Found::Stale("without a span of time".into()),
            other => other,
        },
    }
}

/// Looks for a complete state of `subject` at `path`. Reads the whole file.
pub fn find_state(path: &Path, subject: &Subject) -> Found {
    match read_state(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Found::Missing,
        Err(_) => made_by_others(path).map_or(Found::Damaged, Found::Foreign),
        Ok(state) if !state.is_complete => Found::Damaged,
        Ok(state) if state.subject == *subject => Found::Finished,
        Ok(state) => Found::Stale(first_difference(&state.subject.recipe, &subject.recipe)),
    }
}

/// The first member of `found` that is not in `recipe`, or the first that it lacks.
fn first_difference(found: &str, recipe: &str) -> String {
    let lacking = |of: &str, member: &str| members(of).all(|other| other != member);
    let more = members(found).find(|member| lacking(recipe, member)).map(str::to_owned);
    let less = || members(recipe).find(|member| lacking(found, member));
    let told = more.or_else(|| Some(format!("without {}", less()?)));
    told.unwrap_or_else(|| "the same settings in another order".into()).replace('"', "")
}

/// The members of a recipe, one a line, without commas.
fn members(recipe: &str) -> impl Iterator<Item = &str> {
    recipe.lines().map(|line| line.trim().trim_end_matches(','))
}

#[cfg(test)]
mod tests {
    use slo_scene::{Look, OutputFormat};

    use super::*;
    use crate::output::format::Picture;
    use crate::output::format::samples::sample_image;

    const RECIPE: &str = "{\n  \"frame\": 5,\n  \"seed\": 1\n}";

    #[test]
    fn a_member_at_the_end_is_no_difference() {
        let longer = RECIPE.replace("\n}", ",\n  \"steps\": [7, 120]\n}");
        assert_eq!(first_difference(&longer, RECIPE), "steps: [7, 120]");
        assert_eq!(first_difference(RECIPE, &longer), "without steps: [7, 120]");
    }

    #[test]
    fn finished_missing_damaged_and_stale_are_told_apart() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture");
        for format in OutputFormat::ALL {
            let image = sample_image();
            let look = Look::default();
            let picture = Picture { image: &image, format, look, recipe: RECIPE, crop: None };
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
