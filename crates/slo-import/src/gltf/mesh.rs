//! Meshes, as they are at rest, and as bones and morph targets change them.

use glam::{DMat4, DVec3};
use gltf::mesh::{Mode, Primitive};
use gltf::{Mesh as GltfMesh, Semantic};

use super::accessor::Buffers;
use crate::error::ImportError;
use crate::model::{Mesh, Notes};

/// A primitive: a mesh of one material.
pub(super) struct Part {
    pub(super) mesh: Mesh,
    /// Index of the material; `None` without one.
    pub(super) material: Option<usize>,
    /// The colour that all vertices multiply the material by, if it is not white.
    pub(super) tint: Option<[f32; 3]>,
    /// For each morph target, what it adds to positions and normals.
    targets: Vec<[Vec<[f32; 3]>; 2]>,
    /// For each vertex, joints and their weights.
    joints: Vec<[(u32, f32); 4]>,
}

/// Reads the primitives of a mesh that have triangles.
pub(super) fn parts(
    buffers: Buffers<'_>,
    mesh: &GltfMesh<'_>,
    sets: &[u32],
    notes: &mut Notes,
) -> Result<Vec<Part>, ImportError> {
    let mut parts = Vec::new();
    for primitive in mesh.primitives() {
        if let Some(part) = part(buffers, mesh, &primitive, sets, notes)? {
            parts.push(part);
        }
    }
    Ok(parts)
}

fn part(
    buffers: Buffers<'_>,
    mesh: &GltfMesh<'_>,
    primitive: &Primitive<'_>,
    sets: &[u32],
    notes: &mut Notes,
) -> Result<Option<Part>, ImportError> {
    let name = mesh.name().unwrap_or("mesh").to_owned();
    if !matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        notes.leave_out("points or lines");
        return Ok(None);
    }
    if primitive.extension_value("KHR_draco_mesh_compression").is_some() {
        notes.leave_out("a mesh compressed by Draco");
        return Ok(None);
    }
    let Some(positions) = primitive.get(&Semantic::Positions) else {
        notes.leave_out("a mesh without positions");
        return Ok(None);
    };
    let positions: Vec<[f32; 3]> = buffers.read(&positions)?;
    let of_vertices = |semantic| primitive.get(&semantic).filter(|a| a.count() == positions.len());
    let normals = match of_vertices(Semantic::Normals) {
        Some(normals) => buffers.read(&normals)?,
        None => Vec::new(),
    };
    let set = primitive.material().index().and_then(|m| sets.get(m)).copied().unwrap_or(0);
    let uvs: Vec<[f32; 2]> = match of_vertices(Semantic::TexCoords(set)) {
        Some(uvs) => buffers.read(&uvs)?,
        None => Vec::new(),
    };
    let tint = match primitive.get(&Semantic::Colors(0)) {
        Some(colors) => tint(buffers, &colors, notes)?,
        None => None,
    };
    let corners: Vec<u32> = match primitive.indices() {
        Some(indices) => buffers.read_whole::<1>(&indices)?.into_iter().map(|[i]| i).collect(),
        None => (0..positions.len() as u32).collect(),
    };
    if corners.iter().any(|&corner| corner as usize >= positions.len()) {
        let message = format!("mesh `{name}` has faces of vertices that do not exist");
        return Err(buffers.source.bad(message));
    }
    let faces = faces(primitive.mode(), &corners);
    if faces.is_empty() {
        return Ok(None);
    }
    let targets = targets(buffers, primitive, positions.len())?;
    let joints = match (of_vertices(Semantic::Joints(0)), of_vertices(Semantic::Weights(0))) {
        (Some(joints), Some(weights)) => {
            let (joints, weights) =
                (buffers.read_whole::<4>(&joints)?, buffers.read::<4>(&weights)?);
            let both = joints.into_iter().zip(weights);
            both.map(|(joint, weight)| std::array::from_fn(|i| (joint[i], weight[i]))).collect()
        }
        _ => Vec::new(),
    };
    if primitive.get(&Semantic::Joints(1)).is_some() {
        notes.leave_out("more than four bones of a vertex");
    }
    // In the file v points down.
    let uvs = uvs.into_iter().map(|[u, v]| [u, 1.0 - v]).collect();
    let mesh = Mesh { name, positions, normals, uvs, faces, polygons: Vec::new() };
    Ok(Some(Part { mesh, material: primitive.material().index(), tint, targets, joints }))
}

/// The colour of all vertices. Colours that differ are noted; white is none.
fn tint(
    buffers: Buffers<'_>,
    colors: &gltf::Accessor<'_>,
    notes: &mut Notes,
) -> Result<Option<[f32; 3]>, ImportError> {
    let colors: Vec<[f32; 4]> = if colors.dimensions().multiplicity() == 3 {
        buffers.read::<3>(colors)?.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect()
    } else {
        buffers.read(colors)?
    };
    let Some(&first @ [r, g, b, alpha]) = colors.first() else { return Ok(None) };
    if alpha != 1.0 || colors.iter().any(|color| *color != first) {
        notes.leave_out("colours of vertices");
        return Ok(None);
    }
    Ok(Some([r, g, b]).filter(|color| *color != [1.0; 3]))
}

fn faces(mode: Mode, corners: &[u32]) -> Vec<[u32; 3]> {
    let faces: Vec<[u32; 3]> = match mode {
        Mode::TriangleStrip => {
            let turned = |(i, w): (usize, &[u32])| {
                if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] }
            };
            corners.windows(3).enumerate().map(turned).collect()
        }
        Mode::TriangleFan => {
            let first = corners.first().copied().unwrap_or_default();
            corners.get(1..).unwrap_or_default().windows(2).map(|w| [first, w[0], w[1]]).collect()
        }
        _ => corners.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(),
    };
    // Strips are joined by triangles without an area.
    faces.into_iter().filter(|[a, b, c]| a != b && b != c && c != a).collect()
}

fn targets(
    buffers: Buffers<'_>,
    primitive: &Primitive<'_>,
    vertices: usize,
) -> Result<Vec<[Vec<[f32; 3]>; 2]>, ImportError> {
    let mut targets = Vec::new();
    for target in primitive.morph_targets() {
        let mut columns = [Vec::new(), Vec::new()];
        for (column, accessor) in columns.iter_mut().zip([target.positions(), target.normals()]) {
            if let Some(accessor) = accessor.filter(|accessor| accessor.count() == vertices) {
                *column = buffers.read(&accessor)?;
            }
        }
        targets.push(columns);
    }
    Ok(targets)
}

impl Part {
    /// Whether weights or bones may change it.
    pub(super) fn can_change(&self) -> bool {
        !self.targets.is_empty() || !self.joints.is_empty()
    }

    /// Whether bones place it.
    pub(super) fn has_bones(&self) -> bool {
        !self.joints.is_empty()
    }

    /// The mesh with weights of its morph targets, and with matrices of its bones, if it has any.
    pub(super) fn shaped(&self, weights: &[f64], bones: &[DMat4]) -> Mesh {
        let mut mesh = self.mesh.clone();
        for ([positions, normals], weight) in self.targets.iter().zip(weights) {
            let weight = *weight as f32;
            if weight == 0.0 {
                continue;
            }
            for (column, added) in [(&mut mesh.positions, positions), (&mut mesh.normals, normals)]
            {
                for (vector, added) in column.iter_mut().zip(added) {
                    for (number, added) in vector.iter_mut().zip(added) {
                        *number += weight * added;
                    }
                }
            }
        }
        if !bones.is_empty() {
            for (i, joints) in self.joints.iter().enumerate() {
                let matrix = blended(joints, bones);
                let place = |v: [f32; 3]| DVec3::from(v.map(f64::from));
                let position = matrix.transform_point3(place(mesh.positions[i]));
                mesh.positions[i] = position.as_vec3().to_array();
                if let Some(normal) = mesh.normals.get_mut(i) {
                    *normal = matrix.transform_vector3(place(*normal)).as_vec3().to_array();
                }
            }
        }
        for normal in &mut mesh.normals {
            let unit = glam::Vec3::from(*normal).normalize_or_zero();
            *normal = if unit == glam::Vec3::ZERO { [0.0, 0.0, 1.0] } else { unit.to_array() };
        }
        mesh
    }
}

fn blended(joints: &[(u32, f32); 4], bones: &[DMat4]) -> DMat4 {
    let total: f32 = joints.iter().map(|(_, weight)| weight.max(0.0)).sum();
    if total <= 0.0 {
        return DMat4::IDENTITY;
    }
    let mut sum = DMat4::ZERO;
    for &(joint, weight) in joints {
        if let Some(bone) = bones.get(joint as usize) {
            sum += *bone * f64::from(weight.max(0.0) / total);
        }
    }
    sum
}
