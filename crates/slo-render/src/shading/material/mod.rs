//! Materials at a hit: one file for each kind.
//!
//! Each kind is converted to a [`Material`], one row of the columns of [`MaterialTable`]. A kind
//! that needs other numbers gets columns of its own, and hits are sorted by kind before shading, as
//! they are already sorted by what they show.

pub mod phong;
mod row;
mod table;

use slo_scene::MaterialKind;

pub use row::Material;
pub use table::MaterialTable;

/// Prepares a material of a scene for shading.
pub fn ready(material: &slo_scene::Material) -> Material {
    match &material.kind {
        MaterialKind::Phong(phong) => phong::row(phong),
    }
}
