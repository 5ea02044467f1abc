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

pub use images::{Image, MaterialImages};
pub use kind::Kind;
pub use row::Material;
pub use table::MaterialTable;
