//! `--recipe`: prints how a picture was made.

use std::path::Path;

use crate::cli::base::{Exit, Problem, print};
use crate::cli::files::pictures::NO_PICTURE;
use slo_picture::output::{RecipeError, is_companion, read_recipe};

/// Prints the recipe inside `picture`.
pub(crate) fn run(picture: &Path) -> Result<(), Problem> {
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
