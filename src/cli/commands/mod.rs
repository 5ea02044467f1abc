//! The commands of the program. No command imports another.

pub(crate) mod bake;
pub(crate) mod check;
pub(crate) mod compare;
pub(crate) mod denoise;
pub(crate) mod generate;
pub(crate) mod import;
pub(crate) mod merge;
pub(crate) mod recipe;
pub(crate) mod relight;
pub(crate) mod render;
pub(crate) mod sheet;
pub(crate) mod verify;
pub(crate) mod view;
pub(crate) mod why;
