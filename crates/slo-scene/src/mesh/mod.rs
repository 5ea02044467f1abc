//! Mesh files: `.slo`, `.obj`, `.ply`.

mod append;
mod data;
mod finish;
mod load;
mod normals;
mod not_finite;
mod numbers;
mod obj;
mod ply;
mod polygons;
pub mod slo;
mod stand;
mod tangent;
mod tangents;
mod warnings;

pub use data::{LoadedMesh, Mesh};
pub use load::load;
pub(crate) use load::{BYTE_ORDER_MARK, kind};
pub use tangent::Tangent;
