//! How a picture was made, and what came of it: the text inside every picture, part and state.

mod baked;
mod continuation;
mod outcome;
mod read;
mod relit;
mod restore;
mod write;

pub use baked::{is_light_map, with_light_map};
pub use continuation::{continues, has_same_samples};
pub use outcome::{Outcome, is_denoised, with_denoiser, with_outcome, without_outcome};
pub(super) use read::restore_settings;
pub use read::{layers_of, settings_of, steps_of};
pub use relit::{is_relit, with_look, with_relit};
pub use restore::{RestoreError, restore};
pub use write::{Recipe, with_region, with_steps};
