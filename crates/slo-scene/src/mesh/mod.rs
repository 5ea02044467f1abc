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

/// Bytes that reading a mesh takes for each byte of its file: 1.0 for a large `.obj`, 2.2 for a binary `.ply` of a
/// smooth mesh, at the highest.
pub(crate) const BYTES_OF_BYTE: u64 = 2;

/// Bytes that reading placements takes for each byte of their file, while the columns grow: three numbers of four
/// bytes become three of eight.
pub(crate) const BYTES_OF_PLACED_BYTE: u64 = 4;

pub use data::{LoadedMesh, Mesh};
pub(crate) use load::{BYTE_ORDER_MARK, extension, kind, load_placements};
pub use load::{load, load_shape};
pub use tangent::Tangent;
