//! Syntax tree -> scene: every element in its room, references followed.

mod camera;
mod collect;
mod elements;
mod key_frames;
mod oddities;
mod overlaps;
mod resolver;
mod settings;

pub(crate) use resolver::resolve;
