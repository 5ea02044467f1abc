//! The camera as the person moves it.

mod hold;
mod moves;

pub(crate) use hold::{Held, hold};
pub(crate) use moves::{Move, axes, moved};
