//! Mesh files: `.slo`, `.obj`, `.ply`.

mod append;
mod finish;
mod normals;
mod obj;
mod ply;
pub mod slo;

use std::io::{Cursor, Read};

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
    let extension = extension(path_name);
    let start = start(reader)?;
    if extension != "slo"
        && let Some(kind) = kind(start.get_ref()).filter(|kind| *kind != extension)
    {
        return Err(FileError::whole_file(format!("this is a .{kind} mesh"))
            .with_help(format!("give the file the extension .{kind}")));
    }
    let reader = &mut start.chain(reader);
    let mesh = match extension.as_str() {
        "slo" => slo::read(reader)?,
        "obj" => obj::read(reader, smooth)?,
        "ply" => ply::read(reader)?,
        other => return Err(unknown_extension(other)),
    };
    finish::finish(mesh, smooth, scale)
}

/// What some editors put in front of UTF-8 text.
pub(super) const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// The first bytes of a file, without byte order mark.
fn start(reader: &mut dyn Read) -> Result<Cursor<Vec<u8>>, FileError> {
    let mut bytes = Vec::new();
    Read::take(&mut *reader, 64)
        .read_to_end(&mut bytes)
        .map_err(|e| FileError::whole_file(format!("the mesh can't be read: {e}")))?;
    if bytes.starts_with(BYTE_ORDER_MARK) {
        bytes.drain(..BYTE_ORDER_MARK.len());
    }
    Ok(Cursor::new(bytes))
}

/// What follows the last point of the file's name, in lower case; empty where there is none.
fn extension(path_name: &str) -> String {
    let name = path_name.rsplit(['/', '\\']).next().unwrap_or_default();
    name.rsplit_once('.').map(|(_, extension)| extension.to_lowercase()).unwrap_or_default()
}

/// The extension that the first word of a file asks for, where it is one of a mesh.
pub(super) fn kind(start: &[u8]) -> Option<&'static str> {
    let first = start.split(|byte| byte.is_ascii_whitespace()).next()?;
    match first {
        b"slo_mesh" => Some("slo"),
        b"ply" => Some("ply"),
        _ => None,
    }
}

/// A file that is called like no mesh.
fn unknown_extension(extension: &str) -> FileError {
    let message = match extension {
        "" => "a mesh file needs an extension that says its format".to_owned(),
        _ => format!("`.{extension}` is no known mesh format"),
    };
    FileError::whole_file(message).with_help("meshes are .slo, .obj or .ply files")
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

    fn error_of(name: &str, bytes: &[u8]) -> (String, String) {
        let error = load(name, &mut &*bytes, false, 1.0).expect_err(name);
        (error.message, error.help.map(String::from).unwrap_or_default())
    }

    #[test]
    fn byte_order_marks_are_passed_over() {
        let slo = "slo_mesh 1 vertices { 0 0 0 1 0 0 0 1 0 } faces { 0 1 2 }";
        for (name, text) in [("a.obj", TRIANGLE), ("a.slo", slo)] {
            let plain = load(name, &mut text.as_bytes(), false, 1.0).expect(name);
            let marked = format!("\u{feff}{text}");
            assert_eq!(load(name, &mut marked.as_bytes(), false, 1.0).expect(name), plain);
        }
    }

    #[test]
    fn a_wrong_extension_is_recognised() {
        let is = |kind: &str| {
            (format!("this is a .{kind} mesh"), format!("give the file the extension .{kind}"))
        };
        assert_eq!(error_of("a.obj", b"slo_mesh 1\nvertices { }"), is("slo"));
        assert_eq!(error_of("a.ply", b"slo_mesh 1\nvertices { }"), is("slo"));
        assert_eq!(error_of("a.obj", b"ply\r\nformat ascii 1.0\n"), is("ply"));
        assert_eq!(error_of("a.stl", b"ply\nformat ascii 1.0\n"), is("ply"));
    }

    #[test]
    fn dropped_triangles_are_counted() {
        let warnings = |faces: &str| {
            let text = format!("{TRIANGLE}{faces}");
            load("a.obj", &mut text.as_bytes(), false, 1.0).expect("a mesh").warnings
        };
        assert_eq!(warnings(""), [""; 0]);
        let one = "1 of 2 triangles has no area and was dropped (face 1)";
        assert_eq!(warnings("f 1 1 2\n"), [one]);
        let two = "2 of 3 triangles have no area and were dropped (the first is face 1)";
        assert_eq!(warnings("f 1 1 2\nf 2 1 2\n"), [two]);
    }
}
