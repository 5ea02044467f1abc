//! NURBS surfaces, as triangles. Curves that cut them do not count.
//!
//! Basis functions: L. Piegl, W. Tiller, "The NURBS Book" (1995), algorithms A2.1 and A2.2.

use glam::DVec3;

use super::scene::{Scene, name_of};
use super::state::State;
use super::tree::Node;

use crate::model::Mesh;

/// Pieces of a side between two knots.
const PIECES: usize = 8;

/// Highest order.
const MOST_ORDER: usize = 16;

/// Most vertices of a surface.
const MOST_VERTICES: usize = 4_000_000;

/// Step between two places whose difference is a tangent, as a share of the whole side.
const STEP: f64 = 1e-4;

/// Adds a surface. Returns whether the node is one.
pub(super) fn add(scene: &mut Scene, node: &Node, state: &State) -> bool {
    if !matches!(node.class.as_str(), "NurbsSurface" | "IndexedNurbsSurface") {
        return false;
    }
    let Some(surface) = Surface::of(node, state) else {
        scene.model.notes.leave_out("a damaged NURBS surface");
        return true;
    };
    scene.model.notes.leave_out("that a NURBS surface is round: it became triangles");
    let name = node.name.as_deref().and_then(name_of).or_else(|| state.name.clone());
    let mesh = surface.mesh(name.unwrap_or_else(|| "surface".into()), state);
    let material = scene.looks.material(&[0], state, &mut scene.model);
    scene.mesh(mesh, material, state);
    true
}

/// A direction of a surface.
struct Side<'a> {
    knots: &'a [f64],
    /// Number of control points.
    count: usize,
    order: usize,
}

struct Surface<'a> {
    u: Side<'a>,
    v: Side<'a>,
    /// Control points and their weights; those along u follow each other.
    points: Vec<(DVec3, f64)>,
}

impl<'a> Side<'a> {
    fn of(knots: &'a [f64], count: f64) -> Option<Self> {
        let count = count.max(0.0) as usize;
        let order = knots.len().checked_sub(count)?;
        let rises = knots.windows(2).all(|pair| pair[0] <= pair[1]);
        let side = Self { knots, count, order };
        let is_whole = (2..=MOST_ORDER.min(count)).contains(&order) && rises;
        (is_whole && side.start() < side.end()).then_some(side)
    }

    fn start(&self) -> f64 {
        self.knots[self.order - 1]
    }

    fn end(&self) -> f64 {
        self.knots[self.count]
    }

    /// Parameters of vertices.
    fn samples(&self) -> Vec<f64> {
        let inner = &self.knots[self.order - 1..=self.count];
        let mut samples = vec![self.start()];
        for pair in inner.windows(2).filter(|pair| pair[0] < pair[1]) {
            let piece = |i: usize| pair[0] + (pair[1] - pair[0]) * i as f64 / PIECES as f64;
            samples.extend((1..=PIECES).map(piece));
        }
        samples
    }

    /// The first control point that counts at a parameter, and the weights of it and those that follow.
    fn basis(&self, at: f64) -> (usize, [f64; MOST_ORDER]) {
        let at = at.clamp(self.start(), self.end());
        let inner = &self.knots[..=self.count];
        let span = inner.partition_point(|&knot| knot <= at).clamp(self.order, self.count) - 1;
        // At the end, the last piece with a length counts.
        let has_length = |&i: &usize| self.knots[i] < self.knots[i + 1];
        let span = (self.order - 1..=span).rev().find(has_length).unwrap_or(span);
        let mut weights = [0.0; MOST_ORDER];
        weights[0] = 1.0;
        for degree in 1..self.order {
            let mut saved = 0.0;
            for (i, weight) in weights.iter_mut().enumerate().take(degree) {
                let (right, left) = (self.knots[span + i + 1], self.knots[span + 1 + i - degree]);
                let share = *weight / (right - left);
                *weight = saved + (right - at) * share;
                saved = (at - left) * share;
            }
            weights[degree] = saved;
        }
        (span + 1 - self.order, weights)
    }
}

impl<'a> Surface<'a> {
    fn of(node: &'a Node, state: &State) -> Option<Self> {
        let side =
            |knots: &str, count: &str| Side::of(node.numbers(knots)?, node.number(count, 0.0));
        let u = side("uKnotVector", "numUControlPoints")?;
        let v = side("vKnotVector", "numVControlPoints")?;
        let count = u.count.checked_mul(v.count)?;
        let point =
            |i: usize| Some((*state.points.get(i)?, state.weights.get(i).copied().unwrap_or(1.0)));
        let points: Option<Vec<_>> = match node.indices("coordIndex") {
            Some(indices) if node.class.starts_with("Indexed") => {
                indices.into_iter().take(count).map(|i| point(usize::try_from(i).ok()?)).collect()
            }
            _ if count <= state.points.len() => (0..count).map(point).collect(),
            _ => None,
        };
        Some(Self { u, v, points: points.filter(|points| points.len() == count)? })
    }

    fn at(&self, u: f64, v: f64) -> DVec3 {
        let ((first_u, along_u), (first_v, along_v)) = (self.u.basis(u), self.v.basis(v));
        let (mut sum, mut total) = (DVec3::ZERO, 0.0);
        for (j, weight_v) in along_v.iter().enumerate().take(self.v.order) {
            for (i, weight_u) in along_u.iter().enumerate().take(self.u.order) {
                let (point, weight) = self.points[(first_v + j) * self.u.count + first_u + i];
                let share = weight * weight_u * weight_v;
                sum += point * share;
                total += share;
            }
        }
        if total == 0.0 { sum } else { sum / total }
    }

    /// The normal, where a side may be a single point.
    fn normal(&self, u: f64, v: f64) -> DVec3 {
        let within = |side: &Side<'_>, at: f64| {
            let step = (side.end() - side.start()) * STEP;
            (at.clamp(side.start() + step, side.end() - step), step)
        };
        let ((u, du), (v, dv)) = (within(&self.u, u), within(&self.v, v));
        let along_u = self.at(u + du, v) - self.at(u - du, v);
        let along_v = self.at(u, v + dv) - self.at(u, v - dv);
        along_u.normalize_or_zero().cross(along_v.normalize_or_zero()).normalize_or(DVec3::Y)
    }

    fn mesh(&self, name: String, state: &State) -> Mesh {
        let mut mesh = Mesh { name, ..Mesh::default() };
        let (us, vs) = (self.u.samples(), self.v.samples());
        if us.len().saturating_mul(vs.len()) > MOST_VERTICES {
            return mesh;
        }
        let share = |side: &Side<'_>, at: f64| (at - side.start()) / (side.end() - side.start());
        let turned = if state.is_clockwise { -1.0 } else { 1.0 };
        for &v in &vs {
            for &u in &us {
                mesh.positions.push(self.at(u, v).as_vec3().to_array());
                mesh.normals.push((self.normal(u, v) * turned).as_vec3().to_array());
                let uv = glam::DVec2::new(share(&self.u, u), share(&self.v, v));
                if state.texture.is_some() {
                    mesh.uvs.push(state.texture_place.transform_point2(uv).as_vec2().to_array());
                }
            }
        }
        let width = us.len() as u32;
        for j in 1..vs.len() as u32 {
            for i in 1..width {
                let c = j * width + i;
                let (a, b, d) = (c - width - 1, c - width, c - 1);
                let faces = if state.is_clockwise {
                    [[a, c, b], [a, d, c]]
                } else {
                    [[a, b, c], [a, c, d]]
                };
                // A side that is a single point has triangles without an area.
                let place = |corner: u32| mesh.positions[corner as usize];
                let has_area = |face: &[u32; 3]| {
                    let [a, b, c] = face.map(place);
                    a != b && b != c && c != a
                };
                mesh.faces.extend(faces.into_iter().filter(has_area));
            }
        }
        mesh
    }
}
