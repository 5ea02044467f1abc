//! Materials at a hit: one file for each kind.
//!
//! Each kind has columns of its own in [`MaterialTable`], indexed by the material. Materials of other
//! kinds have an empty row there.

mod images;
mod kind;
pub mod phong;
pub mod principled;
mod row;
mod table;

use slo_scene::MaterialKind;

pub use images::{Image, MaterialImages};
pub use kind::Kind;
pub use row::Material;
pub use table::MaterialTable;

/// Prepares a material of a scene for shading, if it is a Phong material. The row of another one is
/// empty.
pub fn row(material: &slo_scene::Material) -> Material {
    match &material.kind {
        MaterialKind::Phong(phong) => phong::row(phong),
        MaterialKind::Principled(_) | MaterialKind::Mix(_) => Material::default(),
    }
}
