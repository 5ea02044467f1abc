//! Exact sums of samples per pixel, and how they become pixel values.
//!
//! A contribution is rounded once to a fixed-point number and added as an integer. Integer sums do
//! not depend on their order: threads, tiles, batches, parts and resumed runs may add in any order, and
//! the bits stay the same.

mod agx;
mod area;
mod display;
mod features;
mod first_hits;
mod fixed;
mod grid;
mod groups;
mod ids;
mod image;
mod layers;
mod mask;
mod memory;
mod merge;
mod pixel;
mod state;
mod steps;
mod toning;
mod view;
mod wide;

pub use area::{Area, BLOCK, TILE};
pub use display::{Display, linear, luminance, srgb};
pub use features::Features;
pub use first_hits::{FirstHitLayers, FirstHits, Place, PlaceLayers};
pub use fixed::{Fixed, SignedFixed};
pub use grid::Film;
pub use ids::IdCounts;
pub use image::Image;
pub use layers::FileLayer;
pub use mask::{Mask, MaskKind, mask_id};
pub use memory::TooLarge;
pub use merge::{MergeError, Merger};
pub use pixel::{LEAST_FOR_NOISE, Pixel, Spread, base_end, split};
pub use slo_scene::Layer;
pub use state::{State, Subject};
pub use steps::{Steps, tiles_in_order};
pub use toning::Toning;
pub use view::{Pixels, View};
pub use wide::Wide;
