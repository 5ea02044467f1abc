//! Phong, glossy lobes, textures and lights at a hit. Knows no structures.

pub mod light;
pub mod lobe;
pub mod phong;
pub mod table;
pub mod texture;

pub use light::Light;
pub use phong::Material;
pub use table::MaterialTable;
