//! Vertices and faces of a `.ply` file.

use glam::DVec3;

use super::header::{Element, Header, Property, Scalar};
use super::values::{Context, Values};
use crate::format::FileError;
use crate::scene::Mesh;

/// Items that memory is set aside for on the word of the header alone.
const MAX_RESERVE: u64 = 1 << 16;

/// What a number of a vertex is for; the axis is an index into the vector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Slot {
    Position(usize),
    Normal(usize),
    Uv(usize),
    Unused,
}

impl Slot {
    /// What a property of that name is for.
    fn named(name: &str) -> Self {
        match name {
            "x" => Self::Position(0),
            "y" => Self::Position(1),
            "z" => Self::Position(2),
            "nx" => Self::Normal(0),
            "ny" => Self::Normal(1),
            "nz" => Self::Normal(2),
            "s" | "u" | "texture_u" | "texture_s" => Self::Uv(0),
            "t" | "v" | "texture_v" | "texture_t" => Self::Uv(1),
            _ => Self::Unused,
        }
    }
}

/// Reads all elements.
///
/// # Errors
/// The first fault, or no vertices or faces.
pub(super) fn read(header: &Header, values: &mut Values<'_>) -> Result<Mesh, FileError> {
    let vertices = only(header, "vertex")?;
    let faces = only(header, "face")?;
    let mut mesh = Mesh::default();
    for element in &header.elements {
        if element == vertices {
            read_vertices(element, values, &mut mesh)?;
        } else if element == faces {
            read_faces(element, values, vertices.count, &mut mesh)?;
        } else {
            skip(element, values)?;
        }
    }
    if mesh.faces.is_empty() {
        return Err(FileError::whole_file("the mesh has no faces"));
    }
    if !mesh.uvs.is_empty() {
        mesh.face_uvs.clone_from(&mesh.faces);
    }
    Ok(mesh)
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

/// Reads positions, and normals and uvs where all of their properties are there.
fn read_vertices(
    element: &Element,
    values: &mut Values<'_>,
    mesh: &mut Mesh,
) -> Result<(), FileError> {
    let slots: Vec<_> = element.properties.iter().map(slot).collect();
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        if !slots.contains(&Slot::Position(axis)) {
            return Err(FileError::whole_file(format!("a vertex has no property `{name}`")));
        }
    }
    let with_normals = (0..3).all(|axis| slots.contains(&Slot::Normal(axis)));
    let with_uvs = (0..2).all(|axis| slots.contains(&Slot::Uv(axis)));
    mesh.positions.reserve(element.count.min(MAX_RESERVE) as usize);
    for item in 0..element.count {
        let mut position = [0.0; 3];
        let mut normal = [0.0; 3];
        let mut uv = [0.0; 2];
        for (property, slot) in element.properties.iter().zip(&slots) {
            match *slot {
                Slot::Position(axis) => {
                    position[axis] =
                        values.next(property.scalar, context(element, item, property))?;
                }
                Slot::Normal(axis) => normal[axis] = next_f32(values, element, item, property)?,
                Slot::Uv(axis) => uv[axis] = next_f32(values, element, item, property)?,
                Slot::Unused => skip_property(element, item, property, values)?,
            }
        }
        mesh.positions.push(DVec3::from_array(position));
        if with_normals {
            mesh.normals.push(normal);
        }
        if with_uvs {
            mesh.uvs.push(uv);
        }
    }
    Ok(())
}

/// What a property of a vertex is for; lists are for nothing.
fn slot(property: &Property) -> Slot {
    if property.list.is_some() { Slot::Unused } else { Slot::named(&property.name) }
}

/// What is read.
fn context<'h>(element: &'h Element, item: u64, property: &'h Property) -> Context<'h> {
    Context { element: &element.name, item, property: &property.name }
}

/// The next number, rounded to f32.
fn next_f32(
    values: &mut Values<'_>,
    element: &Element,
    item: u64,
    property: &Property,
) -> Result<f32, FileError> {
    let context = context(element, item, property);
    let value = values.next(property.scalar, context)? as f32;
    if value.is_finite() { Ok(value) } else { Err(values.fault(context, "is too large")) }
}

/// Reads faces as fans of triangles; there are `vertices` to refer to.
fn read_faces(
    element: &Element,
    values: &mut Values<'_>,
    vertices: u64,
    mesh: &mut Mesh,
) -> Result<(), FileError> {
    let is_corners =
        |p: &Property| p.list.is_some() && (p.name == "vertex_indices" || p.name == "vertex_index");
    let Some(corners) = element.properties.iter().find(|p| is_corners(p)) else {
        return Err(FileError::whole_file("a face has no list `vertex_indices`"));
    };
    mesh.faces.reserve(element.count.min(MAX_RESERVE) as usize);
    for item in 0..element.count {
        for property in &element.properties {
            if property == corners {
                read_fan(element, item, property, values, vertices, mesh)?;
            } else {
                skip_property(element, item, property, values)?;
            }
        }
    }
    Ok(())
}

/// Reads the corners of one face.
fn read_fan(
    element: &Element,
    item: u64,
    property: &Property,
    values: &mut Values<'_>,
    vertices: u64,
    mesh: &mut Mesh,
) -> Result<(), FileError> {
    let context = context(element, item, property);
    let len = list_len(property, values, context)?;
    if len < 3 {
        return Err(values.fault(context, &format!("has {len} corners, not 3 or more")));
    }
    let first = next_index(property.scalar, values, context, vertices)?;
    let mut last = next_index(property.scalar, values, context, vertices)?;
    for _ in 2..len {
        let next = next_index(property.scalar, values, context, vertices)?;
        mesh.faces.push([first, last, next]);
        last = next;
    }
    Ok(())
}

/// The next index of a vertex.
fn next_index(
    scalar: Scalar,
    values: &mut Values<'_>,
    context: Context<'_>,
    vertices: u64,
) -> Result<u32, FileError> {
    let value = values.next(scalar, context)?;
    let index = value as u32;
    if f64::from(index) != value || u64::from(index) >= vertices {
        let what =
            format!("refers to vertex {value}, but there are {vertices} vertices, from 0 on");
        return Err(values.fault(context, &what));
    }
    Ok(index)
}

/// The length at the start of a list.
fn list_len(
    property: &Property,
    values: &mut Values<'_>,
    context: Context<'_>,
) -> Result<u32, FileError> {
    let value = values.next(property.list.unwrap_or(property.scalar), context)?;
    let len = value as u32;
    if f64::from(len) == value { Ok(len) } else { Err(values.fault(context, "has no length")) }
}

/// Skips an element that is of no use.
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

/// Skips a property of one item.
fn skip_property(
    element: &Element,
    item: u64,
    property: &Property,
    values: &mut Values<'_>,
) -> Result<(), FileError> {
    let context = context(element, item, property);
    let len = match property.list {
        None => 1,
        Some(_) => list_len(property, values, context)?,
    };
    for _ in 0..len {
        values.skip(property.scalar, context)?;
    }
    Ok(())
}
