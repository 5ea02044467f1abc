//! Materials at a hit: one file for each kind.
//!
//! Each kind becomes a [`Material`], one row of the columns in [`MaterialTable`]. A kind that needs
//! other numbers than these gets columns of its own beside them, and hits are sorted by kind before
//! they are shaded, as they are sorted by what they show.

pub mod phong;
mod row;
mod table;

use slo_scene::MaterialKind;

pub use row::Material;
pub use table::MaterialTable;

/// A material of a scene, ready for shading.
pub fn ready(material: &slo_scene::Material) -> Material {
    match &material.kind {
        MaterialKind::Phong(phong) => phong::row(phong),
    }
}
