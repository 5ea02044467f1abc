//! Tests every primitive: the oracle that the structures are held against.

use super::triangle::{self, ShearedRay};
use super::{Hits, Primitives, Rays};

/// Primitives without a structure.
#[derive(Debug)]
pub struct Brute {
    primitives: Primitives,
    /// Ids of the triangles that have an area.
    solid: Vec<u32>,
}

impl Brute {
    pub(super) fn new(primitives: Primitives) -> Self {
        let solid = (0u32..)
            .zip(&primitives.triangles)
            .filter(|(_, triangle)| !triangle::is_degenerate(triangle))
            .map(|(id, _)| id)
            .collect();
        Self { primitives, solid }
    }

    pub(super) fn primitives(&self) -> &Primitives {
        &self.primitives
    }

    /// Bytes that it holds beyond the primitives.
    pub(super) fn memory(&self) -> usize {
        std::mem::size_of_val(self.solid.as_slice())
    }

    pub(super) fn intersect(&self, rays: &Rays, hits: &mut Hits) {
        for i in 0..rays.len() {
            hits.t[i] = rays.t_max[i];
            self.intersect_triangles(rays, i, hits);
            self.intersect_curved(rays, i, hits);
            if hits.primitive[i] == super::NO_HIT {
                hits.t[i] = f32::INFINITY;
            }
        }
    }

    pub(super) fn occluded(&self, rays: &Rays, blocked: &mut [bool]) {
        for (i, blocked) in blocked.iter_mut().enumerate().take(rays.len()) {
            let (origin, direction, t_max) = (rays.origin(i), rays.direction(i), rays.t_max[i]);
            let sheared = ShearedRay::new(origin, direction);
            let triangles = &self.primitives.triangles;
            *blocked =
                self.solid.iter().any(|&id| {
                    triangle::intersect(&sheared, &triangles[id as usize], t_max).is_some()
                }) || self
                    .primitives
                    .curved
                    .iter()
                    .any(|curved| curved.intersect(origin, direction, t_max).is_some());
        }
    }

    fn intersect_triangles(&self, rays: &Rays, i: usize, hits: &mut Hits) {
        let ray = ShearedRay::new(rays.origin(i), rays.direction(i));
        for &id in &self.solid {
            let triangle = &self.primitives.triangles[id as usize];
            if let Some(hit) = triangle::intersect(&ray, triangle, hits.t[i]) {
                (hits.t[i], hits.u[i], hits.v[i]) = (hit.t, hit.u, hit.v);
                hits.primitive[i] = id;
            }
        }
    }

    fn intersect_curved(&self, rays: &Rays, i: usize, hits: &mut Hits) {
        let (origin, direction) = (rays.origin(i), rays.direction(i));
        for (id, curved) in (self.primitives.triangles.len() as u32..).zip(&self.primitives.curved)
        {
            if let Some((t, part)) = curved.intersect(origin, direction, hits.t[i]) {
                (hits.t[i], hits.u[i], hits.v[i]) = (t, part.to_u(), 0.0);
                hits.primitive[i] = id;
            }
        }
    }
}
