//! No structure: tests every primitive, as the reference of the structures.

use crate::primitives::triangle::{self, ShearedRay};
use crate::primitives::{Curved, Primitives};
use crate::rays::{Coherence, Hits, NO_HIT, Rays};
use crate::structure::interface::{BuildOptions, SpatialIndex};
use crate::structure::study::{Counting, Counts};

/// Primitives without a structure.
#[derive(Debug)]
pub(crate) struct Brute {
    primitives: Primitives,
    /// Ids of the triangles that have an area.
    solid: Vec<u32>,
}

impl SpatialIndex for Brute {
    type Geometry = Primitives;
    type Scratch = ();

    fn build(primitives: Primitives, _: BuildOptions) -> Self {
        let solid = (0u32..)
            .zip(&primitives.triangles)
            .filter(|(_, triangle)| !triangle::is_degenerate(triangle))
            .map(|(id, _)| id)
            .collect();
        Self { primitives, solid }
    }

    #[inline]
    fn geometry(&self) -> &Primitives {
        &self.primitives
    }

    fn overhead(&self) -> usize {
        size_of_val(self.solid.as_slice())
    }

    fn can_count(&self) -> bool {
        true
    }

    fn count(&self, rays: &Rays, i: usize, any: bool, (): &mut (), counts: &mut Counts) -> f32 {
        let (origin, direction) = (rays.origin(i), rays.direction(i));
        let ray = ShearedRay::new(origin, direction);
        let (mut t_max, mut t) = (rays.t_max[i], f32::INFINITY);
        let all = self.solid.len() + self.primitives.curved.len();
        counts.leaf(all);
        for place in 0..all {
            counts.test();
            let hit = match self.solid.get(place) {
                Some(&id) => {
                    let triangle = &self.primitives.triangles[id as usize];
                    triangle::intersect(&ray, triangle, t_max).map(|hit| hit.t)
                }
                None => {
                    let curved = &self.primitives.curved[place - self.solid.len()];
                    curved.intersect(origin, direction, t_max).map(|(t, _)| t)
                }
            };
            if let Some(hit) = hit {
                (t_max, t) = (hit, hit);
                if any {
                    break;
                }
            }
        }
        t
    }

    fn intersect(
        &self,
        rays: &Rays,
        coherence: Coherence,
        hits: &mut Hits,
        (): &mut (),
    ) -> Coherence {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("fma") {
            // SAFETY: the CPU has the instructions.
            unsafe { self.intersect_by_fma(rays, hits) };
            return coherence;
        }
        self.intersect_by(rays, hits);
        coherence
    }

    fn occluded(
        &self,
        rays: &Rays,
        coherence: Coherence,
        blocked: &mut [bool],
        (): &mut (),
    ) -> Coherence {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("fma") {
            // SAFETY: the CPU has the instructions.
            unsafe { self.occluded_by_fma(rays, blocked) };
            return coherence;
        }
        self.occluded_by(rays, blocked);
        coherence
    }
}

impl Brute {
    /// The same bits as without the instruction, for which a library is called otherwise.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "fma")]
    fn intersect_by_fma(&self, rays: &Rays, hits: &mut Hits) {
        self.intersect_by(rays, hits);
    }

    /// As [`intersect_by_fma`](Self::intersect_by_fma).
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "fma")]
    fn occluded_by_fma(&self, rays: &Rays, blocked: &mut [bool]) {
        self.occluded_by(rays, blocked);
    }

    #[inline(always)]
    fn intersect_by(&self, rays: &Rays, hits: &mut Hits) {
        for i in 0..rays.len() {
            hits.t[i] = rays.t_max[i];
            self.intersect_triangles(rays, i, hits);
            self.intersect_curved(rays, i, hits);
            if hits.primitive[i] == NO_HIT {
                hits.t[i] = f32::INFINITY;
            }
        }
    }

    #[inline(always)]
    fn occluded_by(&self, rays: &Rays, blocked: &mut [bool]) {
        for (i, blocked) in blocked.iter_mut().enumerate().take(rays.len()) {
            *blocked = self.triangles_block(rays, i) || self.curved_block(rays, i);
        }
    }

    #[inline(always)]
    fn triangles_block(&self, rays: &Rays, i: usize) -> bool {
        let ray = ShearedRay::new(rays.origin(i), rays.direction(i));
        // A closure would not be compiled for the instruction set of its caller.
        for &id in &self.solid {
            let triangle = &self.primitives.triangles[id as usize];
            if triangle::intersect(&ray, triangle, rays.t_max[i]).is_some() {
                return true;
            }
        }
        false
    }

    fn curved_block(&self, rays: &Rays, i: usize) -> bool {
        let (origin, direction) = (rays.origin(i), rays.direction(i));
        let blocks = |c: &Curved| c.intersect(origin, direction, rays.t_max[i]).is_some();
        self.primitives.curved.iter().any(blocks)
    }

    #[inline(always)]
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
