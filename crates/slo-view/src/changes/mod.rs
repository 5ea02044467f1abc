//! What changes in the page are in the text of the scene.

mod add;
mod camera;
mod fields;
mod objects;
mod orbit;

pub(crate) use add::{Kind, New, add};
pub(crate) use camera::camera;
pub(crate) use fields::{Field, Place, parts_of, set};
pub(crate) use objects::{copy, find, hide, key_frame, remove};
pub(crate) use orbit::orbit;

use slo_scene::edit::Outline;

/// Significant digits of numbers that the page writes.
pub(crate) const PLACES: usize = 6;

/// The factor of `Scaling`.
pub(crate) fn scaling(outline: &Outline<'_>) -> f64 {
    let numbers = outline.first("Scaling").and_then(|part| part.own_numbers());
    numbers.and_then(|numbers| numbers.first().copied()).filter(|scale| *scale > 0.0).unwrap_or(1.0)
}
