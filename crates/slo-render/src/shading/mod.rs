//! Materials, lobes, textures and lights at hits. Independent of acceleration structures.

pub mod bsdf;
pub mod light;
pub mod lobe;
pub mod material;
pub mod texture;

pub use light::{Lamp, Light, Lights, WithLamp, WithLamps};
pub use material::{Material, MaterialTable, phong};
