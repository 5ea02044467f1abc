//! Phong, glossy lobes, textures and lights at a hit.
pub mod texture;
