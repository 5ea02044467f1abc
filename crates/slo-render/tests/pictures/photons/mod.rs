//! Photons: what they find is known by formulas, and agrees with what paths from the camera find.

mod agreement;
mod flux;
mod mirrored;
mod split;
mod stored;
