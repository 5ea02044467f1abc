//! From the content of a file to a mesh that can be rendered.

use glam::DVec3;

use super::data::LoadedMesh;
use super::normals::{corners, triangle_normal, unit, vertex_normals};
use crate::format::FileError;
use crate::mesh::data::Mesh;

/// The largest coordinate. Its square is still an f32, and the area of a triangle an f64.
pub(super) const MAX_COORDINATE: f64 = 1e18;

/// What becomes of triangles without area.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Hollow {
    Dropped,
    Kept,
}

/// Scales a mesh, drops its degenerate triangles if they are to be dropped, and prepares its normals: none unless `smooth`,
/// otherwise the normals of the file, normalised, or computed ones if the file has none.
///
/// All indices must be in range.
///
/// # Errors
/// No triangle is left, or a vertex lies too far out.
pub(super) fn finish(
    loaded: LoadedMesh,
    smooth: bool,
    scale: f64,
    hollow: Hollow,
) -> Result<LoadedMesh, FileError> {
    let LoadedMesh { mut mesh, mut warnings } = loaded;
    mesh.positions.iter_mut().for_each(|position| *position *= scale);
    check_positions(&mut mesh)?;
    if hollow == Hollow::Dropped {
        warnings.extend(drop_degenerate(&mut mesh)?);
    }
    if smooth {
        complete_normals(&mut mesh);
    } else {
        mesh.normals = Vec::new();
    }
    Ok(LoadedMesh { mesh, warnings })
}

/// Refuses vertices of faces that are too far out. Others move to where a face is, so that they
/// do no harm.
fn check_positions(mesh: &mut Mesh) -> Result<(), FileError> {
    let is_near = |p: &DVec3| p.abs().cmple(DVec3::splat(MAX_COORDINATE)).all();
    if mesh.positions.iter().all(is_near) {
        return Ok(());
    }
    for &vertex in mesh.faces.as_flattened() {
        let position = mesh.positions[vertex as usize];
        if !is_near(&position) {
            return Err(too_far(vertex as usize, position));
        }
    }
    let Some(&[inside, ..]) = mesh.faces.first() else { return Ok(()) };
    let inside = mesh.positions[inside as usize];
    mesh.positions.iter_mut().filter(|p| !is_near(p)).for_each(|p| *p = inside);
    Ok(())
}

/// A vertex beyond the largest coordinate.
fn too_far(vertex: usize, p: DVec3) -> FileError {
    let (x, y, z) = (p.x, p.y, p.z);
    FileError::whole_file(format!(
        "vertex {vertex} is at ({x:e}, {y:e}, {z:e}), beyond the largest coordinate {MAX_COORDINATE:e}"
    ))
}

/// Drops triangles without area; returns a warning with their number.
fn drop_degenerate(mesh: &mut Mesh) -> Result<Option<String>, FileError> {
    let has_area = |face| triangle_normal(corners(&mesh.positions, face)).is_some();
    let before = mesh.faces.len();
    let Some(first) = mesh.faces.iter().position(|&face| !has_area(face)) else {
        return Ok(None);
    };
    let keep: Vec<bool> = mesh.faces.iter().map(|&face| has_area(face)).collect();
    retain(&mut mesh.faces, &keep);
    retain(&mut mesh.face_uvs, &keep);
    let dropped = before - mesh.faces.len();
    if mesh.faces.is_empty() {
        return Err(no_area(before));
    }
    Ok(Some(match dropped {
        1 => format!("1 of {before} triangles has no area and was dropped (face {first})"),
        _ => format!(
            "{dropped} of {before} triangles have no area and were dropped (the first is face {first})"
        ),
    }))
}

/// A mesh of degenerate triangles only.
fn no_area(triangles: usize) -> FileError {
    let message = match triangles {
        1 => "the only triangle has no area".to_owned(),
        _ => format!("none of the {triangles} triangles has an area"),
    };
    FileError::whole_file(message)
}

/// Keeps the items for which `keep` is set; an empty list stays empty.
fn retain<T>(items: &mut Vec<T>, keep: &[bool]) {
    let mut keep = keep.iter();
    items.retain(|_| keep.next().is_none_or(|&k| k));
}

/// Gives every vertex a unit normal.
fn complete_normals(mesh: &mut Mesh) {
    let mut missing = mesh.normals.is_empty();
    for normal in &mut mesh.normals {
        let given = unit(glam::Vec3::from_array(*normal).as_dvec3());
        missing |= given.is_none();
        *normal = given.unwrap_or_default();
    }
    if missing {
        let computed = vertex_normals(&mesh.positions, &mesh.faces);
        mesh.normals.resize(computed.len(), [0.0; 3]);
        for (normal, computed) in mesh.normals.iter_mut().zip(computed) {
            if *normal == [0.0; 3] {
                *normal = computed;
            }
        }
    }
}
