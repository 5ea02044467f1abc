//! What changes in the page are in the text of the scene.

mod camera;
mod fields;
mod objects;

pub(crate) use camera::camera;
pub(crate) use fields::{Field, Place, parts_of, set};
pub(crate) use objects::{copy, hide, key_frame, remove};

use slo_scene::edit::Outline;

/// Significant digits of numbers that the page writes.
const PLACES: usize = 6;

/// The factor of `Scaling`.
fn scaling(outline: &Outline<'_>) -> f64 {
    let numbers = outline.first("Scaling").and_then(|part| part.own_numbers());
    numbers.and_then(|numbers| numbers.first().copied()).filter(|scale| *scale > 0.0).unwrap_or(1.0)
}
