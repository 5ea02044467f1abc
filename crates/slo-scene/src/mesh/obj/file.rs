//! What was read of an `.obj` file, and the mesh that it makes.

use std::collections::HashMap;

use glam::DVec3;

use super::index::References;
use super::left_out::LeftOut;
use super::lines::Lines;
use super::statement::WrittenCorner;
use crate::format::FileError;
use crate::mesh::data::LoadedMesh;
use crate::mesh::data::Mesh;
use crate::mesh::normals::unit;
use crate::mesh::not_finite::NotFinite;
use crate::mesh::polygons::Polygons;
use crate::mesh::warnings::{few_corners, odd_numbers};

/// Everything that a file lists, with the indices of the file.
#[derive(Debug, Default)]
pub(super) struct File {
    pub(super) positions: Vec<DVec3>,
    pub(super) not_finite: NotFinite,
    pub(super) uvs: Vec<[f32; 2]>,
    /// With length 1; zero if it has no direction, NaN if a coordinate is not finite. Empty if
    /// normals are not needed.
    pub(super) normals: Vec<[f32; 3]>,
    pub(super) normal_count: u64,
    pub(super) left_out: LeftOut,
    references: References,
    face_count: usize,
    /// Faces of fewer than three corners, and the line of the first.
    small_faces: (usize, usize),
    polygons: Polygons,
    faces: Vec<[u32; 3]>,
    face_uvs: CornerIndices,
    face_normals: CornerIndices,
}

/// Indices of uvs or normals from 1, three for each triangle, and 0 if it has none. Empty if no
/// triangle has any.
#[derive(Debug, Default)]
struct CornerIndices(Vec<[u32; 3]>);

impl CornerIndices {
    /// Adds the uvs of triangle number `before`.
    fn push(&mut self, before: usize, triangle: [u32; 3]) {
        if !self.0.is_empty() || triangle[0] > 0 {
            self.0.resize(before, [0; 3]);
            self.0.push(triangle);
        }
    }
}

impl File {
    /// Takes note of a normal.
    pub(super) fn normal(&mut self, normal: DVec3, smooth: bool) {
        self.normal_count += 1;
        if smooth {
            let none = if normal.is_nan() { [f32::NAN; 3] } else { [0.0; 3] };
            self.normals.push(unit(normal).unwrap_or(none));
        }
    }

    /// How many vertices, uvs and normals there were so far.
    pub(super) fn counts(&self) -> [u64; 3] {
        [self.positions.len() as u64, self.uvs.len() as u64, self.normal_count]
    }

    /// Adds a face of the line that was read last, without uvs or normals that only some of its
    /// corners have.
    pub(super) fn face(&mut self, corners: &[WrittenCorner], lines: &Lines<'_>) {
        let missing = corners.iter().enumerate().flat_map(|(number, corner)| {
            corner.missing.iter().map(move |missing| (missing, number))
        });
        self.references
            .note(missing, |corner| lines.place(corners[corner].start, corners[corner].len));
        if corners.len() < 3 {
            return self.small_face(lines);
        }
        self.polygons.push(self.face_count, self.faces.len(), corners.len());
        self.face_count += 1;
        let has = |kind: usize| corners.iter().all(|written| written.corner[kind] > 0);
        let (has_uvs, has_normals) = (has(1), has(2));
        for pair in corners[1..].windows(2) {
            let triangle = [&corners[0], &pair[0], &pair[1]].map(|written| written.corner);
            let part = |kind: usize, is_there: bool| match is_there {
                true => triangle.map(|corner| corner[kind]),
                false => [0; 3],
            };
            self.face_uvs.push(self.faces.len(), part(1, has_uvs));
            self.face_normals.push(self.faces.len(), part(2, has_normals));
            self.faces.push(triangle.map(|corner| corner[0] - 1));
        }
    }

    /// Leaves out a face without an inside.
    fn small_face(&mut self, lines: &Lines<'_>) {
        let (count, line) = &mut self.small_faces;
        *line = if *count == 0 { lines.number() } else { *line };
        *count += 1;
        self.face_count += 1;
    }

    /// A file without faces, and what it has instead.
    fn no_faces(&self) -> FileError {
        let mut help = "an .obj file lists its faces as lines such as `f 1 2 3`".to_owned();
        if let Some((word, line)) = self.left_out.unknown() {
            help.push_str(&format!("; line {line} begins with `{word}`, which is unknown"));
        }
        FileError::whole_file("the mesh has no faces").with_help(help)
    }

    /// The mesh, with what is odd about it.
    ///
    /// # Errors
    /// There are no faces, one refers to what is not there or is not finite, or splitting makes
    /// more vertices than 32-bit indices can count.
    pub(super) fn into_mesh(mut self, smooth: bool) -> Result<LoadedMesh, FileError> {
        let counts = self.counts();
        let to_nothing = std::mem::take(&mut self.references).check(counts)?;
        let mut warnings = Vec::new();
        for (kind, indices) in [(1, &mut self.face_uvs), (2, &mut self.face_normals)] {
            if let Some(line) = to_nothing[kind] {
                indices.0 = Vec::new();
                let what = ["vertices", "uvs", "normals"][kind];
                warnings.push(format!(
                    "faces refer to {what}, but the file has none (the first is in line {line})"
                ));
            }
        }
        let (small, line) = self.small_faces;
        warnings.extend(few_corners(small, &format!("in line {line}")));
        if self.faces.is_empty() {
            return Err(self.no_faces());
        }
        self.not_finite.check(&self.positions, &self.faces)?;
        let others = [&mut self.face_uvs.0[..], &mut self.face_normals.0[..]];
        warnings.extend(self.polygons.cut(&self.positions, &mut self.faces, others));
        warnings.extend(self.left_out.warning());
        let positions = used(&self.positions, &mut self.faces);
        let mut mesh = Mesh { positions, faces: self.faces, ..Mesh::default() };
        let odd_uvs = add_uvs(&mut mesh, &self.uvs, self.face_uvs.0);
        let odd_normals = match smooth {
            true => split(&mut mesh, &self.normals, &self.face_normals.0)?,
            false => 0,
        };
        warnings.extend(odd_numbers(odd_uvs, odd_normals));
        Ok(LoadedMesh { mesh, warnings })
    }
}

/// The items that faces refer to, in the order of their first use; the indices are changed to
/// those of what is returned.
fn used<T: Copy>(items: &[T], faces: &mut [[u32; 3]]) -> Vec<T> {
    let mut numbers = vec![u32::MAX; items.len()];
    let mut used = Vec::with_capacity(items.len());
    for index in faces.as_flattened_mut() {
        let item = *index as usize;
        if numbers[item] == u32::MAX {
            numbers[item] = used.len() as u32;
            used.push(items[item]);
        }
        *index = numbers[item];
    }
    used
}

/// Keeps the uvs that triangles refer to; triangles without get uv (0, 0). How many were not
/// finite: these are (0, 0) too.
fn add_uvs(mesh: &mut Mesh, uvs: &[[f32; 2]], mut face_uvs: Vec<[u32; 3]>) -> usize {
    if face_uvs.is_empty() {
        return 0;
    }
    face_uvs.resize(mesh.faces.len(), [0; 3]);
    // With the uv of triangles that have none in front, indices from 1 are indices from 0.
    let with_none: Vec<_> = std::iter::once([0.0; 2]).chain(uvs.iter().copied()).collect();
    mesh.uvs = used(&with_none, &mut face_uvs);
    mesh.face_uvs = face_uvs;
    let odd = mesh.uvs.iter_mut().filter(|uv| uv[0].is_nan());
    odd.map(|uv| *uv = [0.0; 2]).count()
}

/// Gives vertices the normals of the corners that they are, doubling those that need a second
/// one. How many corners have a normal that is not finite: these are zero as missing ones are.
///
/// # Errors
/// Too many vertices.
fn split(
    mesh: &mut Mesh,
    normals: &[[f32; 3]],
    face_normals: &[[u32; 3]],
) -> Result<usize, FileError> {
    if face_normals.is_empty() {
        return Ok(0);
    }
    let mut odd = 0;
    let mut normal = |index: u32| match index.checked_sub(1).map(|index| normals[index as usize]) {
        Some(normal) if normal[0].is_nan() => {
            odd += 1;
            [0.0; 3]
        }
        found => found.unwrap_or_default(),
    };
    let mut split = Split::new(mesh);
    for face in 0..split.mesh.faces.len() {
        let indices = face_normals.get(face).copied().unwrap_or_default();
        split.face(face, indices.map(&mut normal))?;
    }
    Ok(odd)
}

/// Vertices, each with one normal; those that need a second one are doubled.
struct Split<'m> {
    mesh: &'m mut Mesh,
    /// Whether a vertex has its normal.
    settled: Vec<bool>,
    /// The doubles: which vertex with which normal, as bits.
    doubles: HashMap<(u32, [u32; 3]), u32>,
}
impl<'m> Split<'m> {
    /// No vertex has a normal yet.
    fn new(mesh: &'m mut Mesh) -> Self {
        let vertices = mesh.positions.len();
        mesh.normals = vec![[0.0; 3]; vertices];
        Self { mesh, settled: vec![false; vertices], doubles: HashMap::new() }
    }

    /// Gives the corners of a face their normals.
    fn face(&mut self, face: usize, normals: [[f32; 3]; 3]) -> Result<(), FileError> {
        let mut corners = self.mesh.faces[face];
        for (corner, normal) in corners.iter_mut().zip(normals) {
            *corner = self.corner(*corner, normal)?;
        }
        self.mesh.faces[face] = corners;
        Ok(())
    }

    /// The vertex at the place of `vertex` that has that normal.
    fn corner(&mut self, vertex: u32, normal: [f32; 3]) -> Result<u32, FileError> {
        let index = vertex as usize;
        if !self.settled[index] {
            self.settled[index] = true;
            self.mesh.normals[index] = normal;
        }
        if self.mesh.normals[index] == normal {
            return Ok(vertex);
        }
        let key = (vertex, normal.map(f32::to_bits));
        if let Some(&double) = self.doubles.get(&key) {
            return Ok(double);
        }
        let double = u32::try_from(self.mesh.positions.len())
            .ok()
            .filter(|&double| double < u32::MAX)
            .ok_or_else(|| FileError::whole_file("the mesh has too many vertices"))?;
        self.mesh.positions.push(self.mesh.positions[index]);
        self.mesh.normals.push(normal);
        self.doubles.insert(key, double);
        Ok(double)
    }
}
