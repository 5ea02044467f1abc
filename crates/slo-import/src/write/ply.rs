//! Meshes as binary PLY files.

use crate::model::Mesh;

/// Returns a mesh as a file.
pub(super) fn bytes(mesh: &Mesh) -> Vec<u8> {
    let (has_normals, has_uvs) = (!mesh.normals.is_empty(), !mesh.uvs.is_empty());
    let mut header = String::from("ply\nformat binary_little_endian 1.0\n");
    header += &format!("element vertex {}\n", mesh.positions.len());
    let mut properties = vec!["x", "y", "z"];
    if has_normals {
        properties.extend(["nx", "ny", "nz"]);
    }
    if has_uvs {
        properties.extend(["s", "t"]);
    }
    for property in properties {
        header += &format!("property float {property}\n");
    }
    let faces = mesh.faces.len() + mesh.polygons.len();
    let most = mesh.polygons.iter().map(Vec::len).max().unwrap_or(3);
    let is_short = most <= usize::from(u8::MAX);
    let count = if is_short { "uchar" } else { "uint" };
    header +=
        &format!("element face {faces}\nproperty list {count} uint vertex_indices\nend_header\n");
    let mut bytes = header.into_bytes();
    for (i, position) in mesh.positions.iter().enumerate() {
        let normal = mesh.normals.get(i).map_or(&[][..], |normal| &normal[..]);
        let uv = mesh.uvs.get(i).map_or(&[][..], |uv| &uv[..]);
        for number in position.iter().chain(normal).chain(uv) {
            bytes.extend_from_slice(&number.to_le_bytes());
        }
    }
    let polygons = mesh.polygons.iter().map(Vec::as_slice);
    for face in mesh.faces.iter().map(<[u32; 3]>::as_slice).chain(polygons) {
        if is_short {
            bytes.push(face.len() as u8);
        } else {
            bytes.extend_from_slice(&(face.len() as u32).to_le_bytes());
        }
        for corner in face {
            bytes.extend_from_slice(&corner.to_le_bytes());
        }
    }
    bytes
}
