//! Stanford `.ply` meshes: ASCII, and binary of both byte orders.

mod elements;
mod faces;
mod header;
mod left_out;
pub(super) mod placements;
mod properties;
#[cfg(test)]
mod tests;
mod values;
mod vertices;

use std::io::Read;

use header::Header;
use values::Values;

use crate::format::{FileError, Input};
use crate::mesh::data::LoadedMesh;

/// Reads a `.ply` mesh: element `vertex` with `x y z`, and `nx ny nz` and uvs if they are there
/// (`s t`, `u v`, `texture_u texture_v`, `texture_s texture_t`); element `face` with a list
/// `vertex_indices` or `vertex_index`, where polygons are cut into triangles, and a list
/// `texcoord` of the uvs of its corners. Other elements and properties are skipped; a warning names
/// the visible ones. Normals matter only if `smooth` is set.
///
/// # Errors
/// The first fault in the file, with its place if the file is text.
pub(super) fn read(reader: &mut dyn Read, smooth: bool) -> Result<LoadedMesh, FileError> {
    let mut input = Input::new(reader, 0);
    let header = Header::read(&mut input)?;
    elements::read(&header, &mut Values::new(input, header.encoding), smooth)
}
