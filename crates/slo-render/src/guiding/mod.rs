//! Guiding: a field that says where light comes from, learned by pilot paths before the picture.
//!
//! Space is divided by a binary tree, and at each of its leaves a quadtree divides the directions
//! (T. Müller, M. Gross and J. Novák, "Practical Path Guiding for Efficient Light-Transport
//! Simulation", 2017). A ray that follows a rough lobe takes its direction from the lobe or from the
//! field, by chance; the density of both together is the lobe's density for all weights, so the
//! expected picture does not depend on the field. Pilot paths belong to no picture. Their numbers have
//! names of their own, and what they find is added up in integers: the field is a pure function of
//! (scene, frame, seed), never of pixels, tiles or threads.

mod direction;
mod field;
mod file;
mod learning;
mod places;
mod quads;

pub use direction::{direction, pack};
pub use field::{Field, Guide, NOWHERE};
pub use file::{FieldError, KEY};
pub use learning::{Learning, Record};
