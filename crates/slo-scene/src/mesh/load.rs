//! Which reader a mesh file is for, and the errors about files of other kinds.

use std::io::{self, Cursor, Read};

use super::data::LoadedMesh;
use super::finish::Hollow;
use super::{finish, obj, ply, slo};
use crate::file_kinds;
use crate::format::FileError;
use crate::placements::Placements;

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
    finish::finish(read(path_name, reader, smooth)?, smooth, scale, Hollow::Dropped)
}

/// Reads one of the shapes of a mesh, as [`load`] does. Triangles without area stay, since they may
/// have one in other shapes.
///
/// # Errors
/// The file can't be read, is not in its format, or has no triangle.
pub fn load_shape(
    path_name: &str,
    reader: &mut dyn Read,
    smooth: bool,
    scale: f64,
) -> Result<LoadedMesh, FileError> {
    finish::finish(read(path_name, reader, smooth)?, smooth, scale, Hollow::Kept)
}

/// Reads what a file says.
fn read(path_name: &str, reader: &mut dyn Read, smooth: bool) -> Result<LoadedMesh, FileError> {
    let extension = extension(path_name);
    let start = start(reader)?;
    check_kind(&extension, start.get_ref())?;
    let has_old_lines = has_old_lines(&extension, start.get_ref());
    let mut reader = Cursor::new(start.get_ref()).chain(reader);
    let reader: &mut dyn Read =
        if has_old_lines { &mut OldLines(&mut reader) } else { &mut reader };
    let loaded = match extension.as_str() {
        "slo" => slo::read(reader).map(|mesh| LoadedMesh { mesh, warnings: Vec::new() }),
        "obj" => obj::read(reader, smooth),
        "ply" => ply::read(reader, smooth),
        other => return Err(unknown_extension(other)),
    };
    loaded.map_err(|error| explain(error, &extension, start.get_ref()))
}

/// Reads the placements of copies from the vertices of a `.ply` file. Positions are multiplied by
/// `scale`; `kinds` is the number of originals.
///
/// # Errors
/// The file can't be read, or is not such a file.
pub(crate) fn load_placements(
    path_name: &str,
    reader: &mut dyn Read,
    scale: f64,
    kinds: usize,
) -> Result<Placements, FileError> {
    let extension = extension(path_name);
    if extension != "ply" {
        let message = "placements are the vertices of a .ply file";
        return Err(FileError::whole_file(message));
    }
    let start = start(reader)?;
    check_kind(&extension, start.get_ref())?;
    let has_old_lines = has_old_lines(&extension, start.get_ref());
    let mut reader = Cursor::new(start.get_ref()).chain(reader);
    let reader: &mut dyn Read =
        if has_old_lines { &mut OldLines(&mut reader) } else { &mut reader };
    ply::placements::read(reader, scale, kinds)
}

/// Refuses a file whose first bytes are not of the kind that its extension promises.
fn check_kind(extension: &str, start: &[u8]) -> Result<(), FileError> {
    if start.is_empty() {
        return Err(FileError::whole_file("the mesh file is empty"));
    }
    if let Some(kind) = file_kinds::kind_of_text(start) {
        return Err(other_kind(kind));
    }
    if extension != "slo"
        && let Some(kind) = kind(start).filter(|kind| *kind != extension)
    {
        return Err(FileError::whole_file(format!("this is a .{kind} mesh"))
            .with_help(format!("give the file the extension .{kind}")));
    }
    Ok(())
}

/// What is wrong with a text that can't be read, if it is one at all; `start` is its start.
fn explain(error: FileError, extension: &str, start: &[u8]) -> FileError {
    if let Some(kind) = file_kinds::kind(start) {
        return other_kind(kind);
    }
    if !file_kinds::is_binary(start) || extension == "ply" {
        return error;
    }
    FileError::whole_file("the file is not a text, but a binary file")
        .with_help(format!("a .{extension} mesh is a text"))
}

/// A file that is no mesh.
fn other_kind(kind: file_kinds::Kind) -> FileError {
    FileError::whole_file(format!("the file is {}", kind.name)).with_help(kind.help)
}

/// Whether lines of a text end with CR alone, as on old Macs, and its reader knows LF only.
fn has_old_lines(extension: &str, start: &[u8]) -> bool {
    let ascii_ply = || start.windows(12).any(|words| words == b"format ascii");
    let is_text = extension == "slo" || (extension == "ply" && ascii_ply());
    let line_end = start.iter().position(|b| matches!(b, b'\r' | b'\n'));
    let is_cr_alone = |at| start[at] == b'\r' && start.get(at + 1).is_some_and(|b| *b != b'\n');
    is_text && line_end.is_some_and(is_cr_alone)
}

/// A text with LF instead of CR.
struct OldLines<R>(R);

impl<R: Read> Read for OldLines<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let len = self.0.read(buffer)?;
        buffer[..len].iter_mut().filter(|b| **b == b'\r').for_each(|b| *b = b'\n');
        Ok(len)
    }
}

/// What some editors put in front of UTF-8 text.
pub(crate) const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// The first bytes of a file, without byte order mark.
fn start(reader: &mut dyn Read) -> Result<Cursor<Vec<u8>>, FileError> {
    let mut bytes = Vec::new();
    Read::take(&mut *reader, file_kinds::LOOKED_AT as u64)
        .read_to_end(&mut bytes)
        .map_err(|e| FileError::whole_file(format!("the mesh can't be read: {e}")))?;
    if bytes.starts_with(BYTE_ORDER_MARK) {
        bytes.drain(..BYTE_ORDER_MARK.len());
    }
    Ok(Cursor::new(bytes))
}

/// What follows the last point of the file's name, in lower case; empty if there is none.
pub(crate) fn extension(path_name: &str) -> String {
    let name = path_name.rsplit(['/', '\\']).next().unwrap_or_default();
    name.rsplit_once('.').map(|(_, extension)| extension.to_lowercase()).unwrap_or_default()
}

/// The extension that the first word of a file asks for, if it begins a mesh.
pub(crate) fn kind(start: &[u8]) -> Option<&'static str> {
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
    fn a_file_that_is_no_mesh_is_said_to_be_what_it_is() {
        let cases: [(&[u8], &str); 6] = [
            (b"version https://git-lfs.github.com/spec/v1\noid sha256:1\n", "Git LFS"),
            (b"<!DOCTYPE html>\n<html>", "web page"),
            (b"\xff\xfev\0 \0", "UTF-16"),
            (b"\x1f\x8b\x08\0", "gzip"),
            (b"\x89PNG\r\n\x1a\n", "PNG"),
            (b"", "empty"),
        ];
        for (bytes, expected) in cases {
            for name in ["a.obj", "a.ply", "a.slo"] {
                let (message, _) = error_of(name, bytes);
                assert!(message.contains(expected), "{name}: {message}");
            }
        }
        for name in ["a.obj", "a.slo"] {
            let (message, _) = error_of(name, b"cube\0\0\0\x0c\0\0\0");
            assert_eq!(message, "the file is not a text, but a binary file");
        }
        let vrml = "#VRML V2.0 utf8\nShape { }\n";
        assert_eq!(error_of("a.obj", vrml.as_bytes()).0, "the file is a VRML scene");
        let commented = format!("#VRML V2.0 utf8\n{TRIANGLE}");
        assert!(load("a.obj", &mut commented.as_bytes(), false, 1.0).is_ok());
        let padded = format!("o a\0\0\n{TRIANGLE}\u{1a}");
        assert_eq!(
            load("a.obj", &mut padded.as_bytes(), false, 1.0).expect("a mesh").warnings,
            [""; 0]
        );
    }

    #[test]
    fn lines_may_end_in_any_way() {
        let slo = "slo_mesh 1 # one\nvertices { 0 0 0 1 0 0 0 1 0 }\nfaces { 0 1 2 }";
        let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
            property float z\nelement face 1\nproperty list uchar int vertex_index\nend_header\n\
            0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
        let obj = TRIANGLE.replace("f 1", "# all\nf 1 \\\n");
        for (name, text) in [("a.obj", obj.as_str()), ("a.slo", slo), ("a.ply", ply)] {
            let plain = load(name, &mut text.as_bytes(), false, 1.0).expect(name);
            for line_end in ["\r\n", "\r"] {
                let text = text.replace('\n', line_end);
                let read = load(name, &mut text.as_bytes(), false, 1.0).expect(name);
                assert_eq!(read, plain, "{name} {line_end:?}");
            }
        }
        let faulty = TRIANGLE.replace("f 1", "f x").replace('\n', "\r");
        let error = load("a.obj", &mut faulty.as_bytes(), false, 1.0).expect_err("a fault");
        assert_eq!((error.line, error.column, error.line_text.as_str()), (4, 3, "f x 2 3"));
    }

    #[test]
    fn vertices_of_no_face_may_be_anywhere() {
        let slo = |vertex: &str| {
            let text =
                format!("slo_mesh 1 vertices {{ 0 0 0 1 0 0 0 1 0 {vertex} }} faces {{ 0 1 2 }}");
            load("a.slo", &mut text.as_bytes(), true, 1.0).expect("a mesh").mesh
        };
        assert_eq!(slo("1e30 0 0").positions[3].to_array(), [0.0; 3]);
        assert_eq!(slo("5 5 5").positions[3].to_array(), [5.0; 3]);
        let (message, _) = error_of("a.obj", TRIANGLE.replace("1 0 0", "1e30 0 0").as_bytes());
        assert_eq!(message, "vertex 1 is at (1e30, 0e0, 0e0), beyond the largest coordinate 1e18");
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
