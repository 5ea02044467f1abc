//! Meshes whose vertices are moved: what is shown of them, and the new files that hold them.

mod draft;
mod near;
mod rename;

pub(crate) use draft::{Sculpted, Sculptures};
pub(crate) use near::{Eye, near, together};
pub(crate) use rename::{free_name, named, renamed, uses, y_up};
