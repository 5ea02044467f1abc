//! Vertices of a `.ply` file.

use glam::DVec3;

use super::header::{Element, Property};
use super::properties::{context, skip_property};
use super::values::Values;
use crate::format::FileError;
use crate::mesh::data::Mesh;
use crate::mesh::not_finite::NotFinite;

/// Most items that memory is reserved for by the header alone.
pub(super) const MAX_RESERVE: u64 = 1 << 16;

/// What a number of a vertex is for; the axis is an index into the vector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Slot {
    Position(usize),
    Normal(usize),
    Uv(usize),
    Unused,
}

impl Slot {
    /// What a property is for; lists are for nothing.
    fn of(property: &Property) -> Self {
        if property.list.is_some() {
            return Self::Unused;
        }
        match property.name.as_str() {
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

/// Reads positions, and normals and uvs if all of their properties are there. Positions that are
/// not finite are noted; such normals and uvs are NaN.
///
/// # Errors
/// The first fault.
pub(super) fn read_vertices(
    element: &Element,
    values: &mut Values<'_>,
    mesh: &mut Mesh,
    not_finite: &mut NotFinite,
) -> Result<(), FileError> {
    let slots: Vec<_> = element.properties.iter().map(Slot::of).collect();
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
            let context = context(element, item, property);
            if *slot == Slot::Unused {
                skip_property(element, item, property, values)?;
                continue;
            }
            let value = values.next_or_nan(property.scalar, context)?;
            match *slot {
                Slot::Position(axis) => {
                    position[axis] = value;
                    if value.is_nan() {
                        not_finite.note(item as usize, || values.fault(context, "is not finite"));
                    }
                }
                Slot::Normal(axis) => normal[axis] = finite_f32(value),
                Slot::Uv(axis) => uv[axis] = finite_f32(value),
                Slot::Unused => {}
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

/// The number rounded to f32; NaN if it is too large.
pub(super) fn finite_f32(value: f64) -> f32 {
    let value = value as f32;
    if value.is_finite() { value } else { f32::NAN }
}
