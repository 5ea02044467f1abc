//! Pictures as files: formats, names, the recipe inside; never half-written.
//!
//! The bytes of a file depend on the picture and its recipe only: no clock, no host, no thread count,
//! no order of a hash map.
//!
//! ```text
//! file -> recipe -> format -> state -> existing, map
//! ```

mod existing;
mod file;
mod format;
mod map;
mod name;
mod recipe;
mod state;

pub use existing::{Found, find_picture, find_state, find_timed_picture, made_by_others};
pub use file::{
    check_free, check_writable, open_regular, remove_abandoned, remove_leftovers, sweep_abandoned,
    write_atomically, write_new,
};
pub use format::{
    Crop, KEYWORD, Picture, Raster, ReadError, RecipeError, Values, claimed_pixels,
    memory_to_write, read_layers, read_recipe,
};
pub use map::{
    ERRORS, check_companion, is_companion, map_color, map_format, write_cost_map,
    write_difference_map, write_error_map, write_sample_map, write_sheet,
};
pub use name::{Info, check_prefix, file_name};
pub use recipe::{
    Outcome, Recipe, RestoreError, continues, has_same_samples, is_denoised, is_light_map,
    is_relit, layers_of, restore, settings_of, steps_of, with_denoiser, with_light_map, with_look,
    with_outcome, with_region, with_relit, with_steps, without_outcome,
};
pub use state::{read_state, read_subject, write_state};
