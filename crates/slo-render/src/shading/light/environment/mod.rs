//! `environment`: light from all around.

mod even;
mod image;
mod table;

pub use even::EvenSky;
pub use image::{ImageSky, ImageView};
pub use table::{SkyShare, SkyTable};
