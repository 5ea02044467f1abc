//! Phong, glossy lobes, textures and lights at a hit. Knows no structures.

pub mod light;
pub mod lobe;
pub mod material;
pub mod texture;

pub use light::{AnyLight, Light};
pub use material::{Material, MaterialTable, phong};
