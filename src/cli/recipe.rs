//! `--recipe`: how a picture was made.

use std::path::Path;

use super::Exit;
use super::problem::Problem;
use super::terminal::print;
use crate::output::{RecipeError, is_companion, read_recipe};

/// What is said of a file that was made of a picture.
pub(super) const NO_PICTURE: &str = "a map or a sheet of slo-rt, not a picture";

/// Prints the recipe inside `picture`.
pub(super) fn run(picture: &Path) -> Result<(), Problem> {
    let recipe = read_recipe(picture).map_err(|error| {
        let exit = match &error {
            RecipeError::Io(_) => Exit::NoInput,
            _ => Exit::BadInput,
        };
        Problem::new(exit, format!("`{}`: {error}", picture.display()))
    })?;
    if is_companion(&recipe) {
        let message = format!("`{}`: {NO_PICTURE}", picture.display());
        return Err(Problem::new(Exit::BadInput, message));
    }
    print(recipe.as_bytes())
        .map_err(|error| Problem::new(Exit::Failed, format!("can't print the recipe: {error}")))
}
