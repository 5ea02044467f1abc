//! Syntax tree -> scene: every element is read, every reference followed.

mod camera;
mod collect;
mod copies;
mod elements;
mod key_frames;
mod lights;
mod oddities;
mod overlaps;
mod photons;
mod resolver;
mod settings;
mod spaces;
mod tangents;
mod texture;

pub(crate) use resolver::resolve;
