//! Where things are, and what moving, turning or scaling them means for the text.

mod boxes;
mod edits;
mod motion;
mod placed;

pub(crate) use boxes::{boxes, middle};
pub(crate) use edits::edits;
pub(crate) use motion::Motion;
pub(crate) use placed::Placed;
