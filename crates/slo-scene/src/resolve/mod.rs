//! Syntax tree -> scene: every element is read, every reference followed.

mod camera;
mod collect;
mod copies;
mod elements;
mod includes;
mod key_frames;
mod light_maps;
mod lights;
mod oddities;
mod overlaps;
mod photons;
mod repeat;
mod resolver;
mod settings;
mod spaces;
mod tangents;
mod texture;
mod turns;

pub(crate) use crate::attributes::Referred;
pub(crate) use elements::{LANGUAGE, referred};
pub(crate) use resolver::resolve;
