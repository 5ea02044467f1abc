//! Elements of a `.ply` file, put together to a mesh.

use super::faces::Faces;
use super::header::{Element, Header};
use super::left_out;
use super::properties::skip_property;
use super::values::Values;
use super::vertices::read_vertices;
use crate::format::FileError;
use crate::mesh::data::LoadedMesh;
use crate::mesh::data::Mesh;
use crate::mesh::not_finite::NotFinite;
use crate::mesh::warnings::{few_corners, odd_numbers};

/// Reads all elements.
///
/// # Errors
/// The first fault, or no vertices or faces.
pub(super) fn read(
    header: &Header,
    values: &mut Values<'_>,
    smooth: bool,
) -> Result<LoadedMesh, FileError> {
    let vertices = only(header, "vertex")?;
    let faces = only(header, "face")?;
    let mut mesh = Mesh::default();
    let mut not_finite = NotFinite::default();
    let mut reading = Faces::default();
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" => read_vertices(element, values, &mut mesh, &mut not_finite)?,
            "face" => reading.read(faces, values, vertices.count, &mut mesh)?,
            _ => skip(element, values)?,
        }
    }
    let (small, first) = reading.small;
    let mut warnings: Vec<_> = few_corners(small, &format!("face {first}")).into_iter().collect();
    if mesh.faces.is_empty() {
        return Err(FileError::whole_file("the mesh has no faces"));
    }
    not_finite.check(&mesh.positions, &mesh.faces)?;
    warnings.extend(reading.cut(&mut mesh));
    warnings.extend(left_out::warning(header));
    let odd_uvs = reading.finish_uvs(&mut mesh);
    let odd_normals = if smooth { clean_normals(&mut mesh) } else { 0 };
    warnings.extend(odd_numbers(odd_uvs, odd_normals));
    Ok(LoadedMesh { mesh, warnings })
}

/// The one element of that name.
fn only<'h>(header: &'h Header, name: &str) -> Result<&'h Element, FileError> {
    let mut found = header.elements.iter().filter(|element| element.name == name);
    match (found.next(), found.next()) {
        (Some(element), None) => Ok(element),
        (None, _) => Err(FileError::whole_file(format!("the mesh has no element `{name}`"))
            .with_help("a mesh needs the elements `vertex` and `face`; point clouds and strips are not read")),
        _ => Err(FileError::whole_file(format!("the element `{name}` is there twice"))),
    }
}

/// Makes normals that are not finite zero, so that they are computed; how many vertices of faces
/// have such.
fn clean_normals(mesh: &mut Mesh) -> usize {
    let mut odd = 0;
    if mesh.normals.is_empty() {
        return 0;
    }
    for &vertex in mesh.faces.as_flattened() {
        let normal = &mut mesh.normals[vertex as usize];
        if normal.iter().any(|c| c.is_nan()) {
            *normal = [0.0; 3];
            odd += 1;
        }
    }
    odd
}

/// Skips an element that meshes do not need.
fn skip(element: &Element, values: &mut Values<'_>) -> Result<(), FileError> {
    if element.properties.is_empty() {
        return Ok(());
    }
    for item in 0..element.count {
        for property in &element.properties {
            skip_property(element, item, property, values)?;
        }
    }
    Ok(())
}
