//! Faces of a `.ply` file.

use super::header::{Element, Property, Scalar};
use super::properties::{context, list_len, skip_property};
use super::values::{Context, Values};
use super::vertices::{MAX_RESERVE, finite_f32};
use crate::format::FileError;
use crate::mesh::data::Mesh;
use crate::mesh::polygons::Polygons;

/// Faces that are being read.
#[derive(Default)]
pub(super) struct Faces {
    pub(super) polygons: Polygons,
    /// Faces of fewer than three corners, and the number of the first.
    pub(super) small: (usize, u64),
    /// Uvs of corners, of faces that say them.
    uvs: Vec<[f32; 2]>,
    /// Indices into these, from 1, three for each triangle; 0 if it has none. Empty if no triangle
    /// has any.
    face_uvs: Vec<[u32; 3]>,
    /// Vertices of the face that is being read.
    corners: Vec<u32>,
    /// Its texture coordinates.
    texcoords: Vec<f32>,
}

/// What a property of a face is for.
#[derive(Clone, Copy, PartialEq)]
enum Slot {
    Corners,
    Texcoords,
    Unused,
}

impl Slot {
    fn of(property: &Property) -> Self {
        match property.name.as_str() {
            _ if property.list.is_none() => Self::Unused,
            "vertex_indices" | "vertex_index" => Self::Corners,
            "texcoord" | "texcoords" => Self::Texcoords,
            _ => Self::Unused,
        }
    }
}

impl Faces {
    /// Reads faces as fans of triangles; there are `vertices` to refer to.
    ///
    /// # Errors
    /// The first fault.
    pub(super) fn read(
        &mut self,
        element: &Element,
        values: &mut Values<'_>,
        vertices: u64,
        mesh: &mut Mesh,
    ) -> Result<(), FileError> {
        let mut slots: Vec<_> = element.properties.iter().map(Slot::of).collect();
        for kind in [Slot::Corners, Slot::Texcoords] {
            slots.iter_mut().filter(|slot| **slot == kind).skip(1).for_each(|s| *s = Slot::Unused);
        }
        if !slots.contains(&Slot::Corners) {
            return Err(FileError::whole_file("a face has no list `vertex_indices`"));
        }
        mesh.faces.reserve(element.count.min(MAX_RESERVE) as usize);
        for item in 0..element.count {
            self.corners.clear();
            self.texcoords.clear();
            for (property, slot) in element.properties.iter().zip(&slots) {
                let context = context(element, item, property);
                match slot {
                    Slot::Corners => {
                        for _ in 0..list_len(property, values, context)? {
                            let index = next_index(property.scalar, values, context, vertices)?;
                            self.corners.push(index);
                        }
                    }
                    Slot::Texcoords => {
                        for _ in 0..list_len(property, values, context)? {
                            let value = values.next_or_nan(property.scalar, context)?;
                            self.texcoords.push(finite_f32(value));
                        }
                    }
                    Slot::Unused => skip_property(element, item, property, values)?,
                }
            }
            self.add(item, mesh);
            if mesh.faces.len().max(self.uvs.len()) >= u32::MAX as usize {
                return Err(FileError::whole_file("the mesh has too many triangles"));
            }
        }
        Ok(())
    }

    /// Adds the face that was read.
    fn add(&mut self, item: u64, mesh: &mut Mesh) {
        let before = mesh.faces.len();
        let [first, rest @ ..] = &self.corners[..] else { return self.small_face(item) };
        if rest.len() < 2 {
            return self.small_face(item);
        }
        self.polygons.push(item as usize, before, self.corners.len());
        mesh.faces.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
        if self.texcoords.len() == 2 * self.corners.len() {
            self.face_uvs.resize(before, [0; 3]);
            let start = self.uvs.len() as u32 + 1;
            self.uvs.extend(self.texcoords.chunks_exact(2).map(|uv| [uv[0], uv[1]]));
            let last = rest.len() as u32;
            self.face_uvs.extend((1..last).map(|i| [start, start + i, start + i + 1]));
        } else if !self.face_uvs.is_empty() {
            self.face_uvs.resize(mesh.faces.len(), [0; 3]);
        }
    }

    /// Leaves out a face without an inside.
    fn small_face(&mut self, item: u64) {
        let (count, first) = &mut self.small;
        *first = if *count == 0 { item } else { *first };
        *count += 1;
    }

    /// Gives the mesh its uvs: from the corners of faces, or else from the vertices, or
    /// else (0, 0). How many are not finite: these are (0, 0) too.
    pub(super) fn finish_uvs(self, mesh: &mut Mesh) -> usize {
        let own = mesh.uvs.len() as u32;
        if !self.face_uvs.is_empty() {
            let mut face_uvs = self.face_uvs;
            face_uvs.resize(mesh.faces.len(), [0; 3]);
            mesh.uvs.extend(self.uvs);
            let none = mesh.uvs.len() as u32;
            if own == 0 && face_uvs.contains(&[0; 3]) {
                mesh.uvs.push([0.0; 2]);
            }
            let indices = face_uvs.into_iter().zip(&mesh.faces);
            mesh.face_uvs = indices
                .map(|(uvs, face)| match uvs {
                    [0, ..] if own > 0 => *face,
                    [0, ..] => [none; 3],
                    _ => uvs.map(|index| own + index - 1),
                })
                .collect();
        } else if own > 0 {
            mesh.face_uvs.clone_from(&mesh.faces);
        }
        let mut odd = 0;
        for &index in mesh.face_uvs.as_flattened() {
            let uv = &mut mesh.uvs[index as usize];
            if uv.iter().any(|c| c.is_nan()) {
                *uv = [0.0; 2];
                odd += 1;
            }
        }
        // Those of vertices without a face.
        mesh.uvs
            .iter_mut()
            .filter(|uv| uv[0].is_nan() || uv[1].is_nan())
            .for_each(|uv| *uv = [0.0; 2]);
        odd
    }

    /// Cuts polygons; what is odd about them.
    pub(super) fn cut(&mut self, mesh: &mut Mesh) -> Vec<String> {
        self.polygons.cut(&mesh.positions, &mut mesh.faces, [&mut self.face_uvs, &mut []])
    }
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
