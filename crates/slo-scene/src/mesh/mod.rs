//! Mesh files: `.slo`, `.obj`, `.ply`.

mod append;
mod data;
mod finish;
pub(crate) mod kept;
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

/// Bytes that reading a mesh takes for each byte of its file, at most. Measured.
pub(crate) const BYTES_OF_BYTE: u64 = 4;

pub use data::{LoadedMesh, Mesh};
pub(crate) use load::{BYTE_ORDER_MARK, extension, kind, load_placements};
pub use load::{load, load_shape};
pub use tangent::Tangent;
