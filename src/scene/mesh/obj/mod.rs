//! Wavefront `.obj` meshes.
//!
//! Everything in a file becomes one mesh: objects, groups, materials and smoothing groups are
//! ignored, and so are points, lines and free-form surfaces. `tobj` reads the numbers and cuts
//! polygons into fans; it says neither where a fault is nor which corners have no uv or normal,
//! so it reads through [`Lines`], which passes on only lines without fault and takes notes.

mod index;
mod lines;
mod merge;
mod statement;
#[cfg(test)]
mod tests;

use std::io::Read;

use lines::Lines;

use crate::format::FileError;
use crate::scene::Mesh;

/// How `tobj` is to read: corners keep separate indices of position, uv and normal.
const OPTIONS: tobj::LoadOptions = tobj::LoadOptions {
    single_index: false,
    triangulate: true,
    ignore_points: true,
    ignore_lines: true,
};

/// Reads an `.obj` mesh. Normals are kept only where `smooth` is set: a vertex with several of
/// them is then split, so that hard edges stay hard. Uvs have indices of their own.
///
/// # Errors
/// The first fault in the file, with its place; a file without faces.
pub(super) fn read(reader: &mut dyn Read, smooth: bool) -> Result<Mesh, FileError> {
    let mut lines = Lines::new(reader);
    let loaded = tobj::load_obj_buf(&mut lines, &OPTIONS, |_| Err(tobj::LoadError::GenericFailure));
    if let Some(fault) = lines.take_fault() {
        return Err(fault);
    }
    let (models, _) = loaded.map_err(|e| lines.here(format!("the line can't be read: {e}")))?;
    let parts = lines.into_parts();
    // Without groups and materials, which `Lines` leaves out, there is one model at most.
    match models.into_iter().next() {
        Some(model) if !parts.is_empty() => merge::merge(model.mesh, &parts, smooth),
        _ => Err(FileError::whole_file("the mesh has no faces")
            .with_help("an .obj file lists its faces as lines such as `f 1 2 3`")),
    }
}
