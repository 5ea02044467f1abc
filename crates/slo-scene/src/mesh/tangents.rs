//! Tangents for images of normals, by the algorithm of the programs that bake and show such images:
//! MikkTSpace.

#[cfg(test)]
mod tests;

use std::cmp::Ordering;
use std::collections::HashMap;

use bevy_mikktspace::{Geometry, Ops, TangentSpace, generate_tangents};
use glam::DVec3;

use super::data::Mesh;
use super::normals::{corners, triangle_normal};
use super::tangent::Tangent;

/// Most corners that count as one vertex. The algorithm takes time in proportion to the square of
/// their number, and calls itself once for each of them.
const MOST_CORNERS: usize = 256;

impl Mesh {
    /// Computes the tangents of all corners, unless the mesh has no uvs.
    ///
    /// Where uvs have no area, corners get any direction along the surface.
    pub fn add_tangents(&mut self) {
        self.tangents = Vec::new();
        if self.face_uvs.is_empty() {
            return;
        }
        let mut surface = Surface::new(self);
        // With an error, of which there is none yet, corners keep the tangents that they have.
        _ = generate_tangents(&mut surface);
        self.tangents = surface.tangents;
    }
}

/// A mesh as the algorithm sees it.
struct Surface<'m> {
    mesh: &'m Mesh,
    /// Moved and scaled to the cube from -1 to 1.
    positions: Vec<[f32; 3]>,
    /// Corners of vertices with too many of them: how far their normals are changed, in units of the
    /// last place, so that the algorithm takes them for several vertices.
    apart: HashMap<[u32; 2], u32>,
    tangents: Vec<[Tangent; 3]>,
}

impl<'m> Surface<'m> {
    fn new(mesh: &'m Mesh) -> Self {
        let mut surface = Self {
            mesh,
            positions: in_unit_cube(&mesh.positions, &mesh.faces),
            apart: HashMap::new(),
            tangents: Vec::new(),
        };
        let faces = 0..mesh.faces.len();
        surface.tangents =
            faces.clone().map(|face| [0, 1, 2].map(|i| surface.alone(face, i))).collect();
        let corners = faces.flat_map(|face| [0, 1, 2].map(|i| [face as u32, i]));
        surface.apart = surface.crowded(corners.collect());
        surface
    }

    /// The tangent of a corner of a triangle by itself: of those that the algorithm leaves out, and
    /// where triangles are so narrow that their angles are 0 to it.
    fn alone(&self, face: usize, corner: usize) -> Tangent {
        let normal = glam::Vec3::from_array(Geometry::normal(self, face, corner)).as_dvec3();
        let normal = normal.try_normalize().unwrap_or(DVec3::Z);
        let [a, b, c] = corners(&self.mesh.positions, self.mesh.faces[face]);
        let [u, v, w] = [0, 1, 2].map(|corner| self.tex_coord(face, corner).map(f64::from));
        let [along, beside] = [[v[0] - u[0], v[1] - u[1]], [w[0] - u[0], w[1] - u[1]]];
        let is_mirrored = along[0] * beside[1] - along[1] * beside[0] < 0.0;
        let sign = if is_mirrored { -1.0 } else { 1.0 };
        let tangent = ((b - a) * beside[1] - (c - a) * along[1]) * sign;
        let tangent = (tangent - normal * normal.dot(tangent)).try_normalize();
        let tangent = tangent.unwrap_or_else(|| normal.any_orthonormal_vector());
        Tangent::new(tangent.as_vec3().to_array(), is_mirrored).unwrap_or(Tangent::ALONG_X)
    }

    /// The corners past the first [`MOST_CORNERS`] of each vertex, in groups of as many.
    fn crowded(&self, mut corners: Vec<[u32; 2]>) -> HashMap<[u32; 2], u32> {
        let key = |[face, corner]: [u32; 2]| {
            let (face, corner) = (face as usize, corner as usize);
            let [x, y, z] = self.position(face, corner);
            let [nx, ny, nz] = Geometry::normal(self, face, corner);
            let [u, v] = self.tex_coord(face, corner);
            [x, y, z, nx, ny, nz, u, v]
        };
        let order = |a: &[u32; 2], b: &[u32; 2]| {
            let pairs = key(*a).into_iter().zip(key(*b));
            let mut orders = pairs.map(|(a, b)| a.total_cmp(&b));
            orders.find(|order| order.is_ne()).unwrap_or(Ordering::Equal)
        };
        corners.sort_by(order);
        let vertices = corners.chunk_by(|a, b| order(a, b).is_eq());
        let groups = vertices.flat_map(|vertex| vertex.chunks(MOST_CORNERS).enumerate().skip(1));
        groups.flat_map(|(i, group)| group.iter().map(move |corner| (*corner, i as u32))).collect()
    }
}

/// Positions, moved and scaled so that faces lie in the cube from -1 to 1 and keep their digits.
fn in_unit_cube(positions: &[DVec3], faces: &[[u32; 3]]) -> Vec<[f32; 3]> {
    let used = || faces.as_flattened().iter().map(|vertex| positions[*vertex as usize]);
    let low = used().fold(DVec3::INFINITY, DVec3::min);
    let high = used().fold(DVec3::NEG_INFINITY, DVec3::max);
    let center = (low + high) / 2.0;
    let size = (high - center).max_element();
    let scale = if size > 0.0 { 1.0 / size } else { 1.0 };
    positions.iter().map(|p| plain(((*p - center) * scale).as_vec3().to_array())).collect()
}

/// The same numbers, without the sign of 0, which the algorithm would take for a difference.
fn plain<const N: usize>(numbers: [f32; N]) -> [f32; N] {
    numbers.map(|number| number + 0.0)
}

impl Geometry<Portable> for Surface<'_> {
    fn num_faces(&self) -> usize {
        self.mesh.faces.len()
    }

    /// 0 for a triangle without area in f32: the algorithm would compare it with all others.
    fn num_vertices_of_face(&self, face: usize) -> usize {
        let [a, b, c] = [0, 1, 2].map(|corner| self.position(face, corner));
        if a == b || b == c || c == a { 0 } else { 3 }
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.positions[self.mesh.faces[face][corner] as usize]
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        let [x, y, z] = match self.mesh.normals.get(self.mesh.faces[face][corner] as usize) {
            Some(normal) => *normal,
            None => {
                let corners = corners(&self.mesh.positions, self.mesh.faces[face]);
                triangle_normal(corners).unwrap_or(DVec3::Z).as_vec3().to_array()
            }
        };
        let [x, y, z] = plain([x, y, z]);
        let apart = self.apart.get(&[face as u32, corner as u32]).copied().unwrap_or(0);
        [f32::from_bits(x.to_bits() + apart), y, z]
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        plain(self.mesh.uvs[self.mesh.face_uvs[face][corner] as usize])
    }

    fn set_tangent(&mut self, tangent: Option<TangentSpace>, face: usize, corner: usize) {
        let Some(tangent) = tangent else { return };
        let is_mirrored = !tangent.is_orientation_preserving();
        if let Some(tangent) = Tangent::new(tangent.tangent(), is_mirrored) {
            self.tangents[face][corner] = tangent;
        }
    }
}

/// Functions that give the same bits everywhere.
struct Portable;

impl Ops for Portable {
    fn sqrt(x: f32) -> f32 {
        x.sqrt()
    }

    fn acos(x: f32) -> f32 {
        libm::acos(f64::from(x)) as f32
    }
}
