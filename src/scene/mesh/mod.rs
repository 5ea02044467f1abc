//! Mesh files: `.slo`, `.obj`, `.ply`.

mod append;
mod finish;
mod normals;
mod obj;
mod ply;

use std::io::Read;

use super::Mesh;
use crate::format::{FileError, slo};

/// A mesh that can be rendered, and what is odd about its file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadedMesh {
    /// The triangles.
    pub mesh: Mesh,
    /// What was put right, one line each.
    pub warnings: Vec<String>,
}

/// Reads a mesh; the extension of `path_name` (in any case) says which format it is in.
///
/// Positions are multiplied by `scale`. Triangles without area are dropped. With `smooth`, every
/// vertex has a unit normal: the file's, or else the normalised sum of the unit normals of its
/// triangles; without, there are none.
///
/// # Errors
/// The file can't be read, is not in its format, or has no triangle.
pub fn load(
    path_name: &str,
    reader: &mut dyn Read,
    smooth: bool,
    scale: f64,
) -> Result<LoadedMesh, FileError> {
    let mesh = match extension(path_name).as_str() {
        "slo" => slo::read(reader)?,
        "obj" => obj::read(reader, smooth)?,
        "ply" => ply::read(reader)?,
        other => return Err(unknown_extension(other)),
    };
    finish::finish(mesh, smooth, scale)
}

/// What follows the last point of the file's name, in lower case; empty where there is none.
fn extension(path_name: &str) -> String {
    let name = path_name.rsplit(['/', '\\']).next().unwrap_or_default();
    name.rsplit_once('.').map(|(_, extension)| extension.to_lowercase()).unwrap_or_default()
}

/// A file that is called like no mesh.
fn unknown_extension(extension: &str) -> FileError {
    let message = match extension {
        "" => "a mesh file needs an extension that says its format".to_owned(),
        _ => format!("`.{extension}` is no known mesh format"),
    };
    FileError::whole_file(message).with_help("meshes are .slo, .obj or .ply files")
}
