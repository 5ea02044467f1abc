//! The compressed wide hierarchy of the library obvhs, as a yardstick for the other structures.
//!
//! The library builds and traverses. Primitives are tested by our own tests, so hits are the same;
//! but the library's tests of boxes are not conservative, so rays that run along faces of boxes may
//! miss a hit: a few in a hundred thousand, if directions are random. Rays are traced one by one.
//! Source: Ylitie, Karras, Laine, *Efficient Incoherent Ray Traversal on GPUs Through Compressed
//! Wide BVHs* (HPG 2017).

use std::time::Duration;

use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh;
use obvhs::ray::{Ray, RayHit};
use obvhs::{Boundable, BvhBuildParams};

use crate::isa::Isa;
use crate::primitives::Primitives;
use crate::primitives::triangle::{POSITION_ERROR, TriangleHit};
use crate::rays::{Coherence, Hits, Rays};
use crate::structure::interface::{BuildOptions, SpatialIndex};
use crate::structure::shared::single::{Single, can_be_hit};

/// Primitives in obvhs's hierarchy.
#[derive(Debug)]
pub(crate) struct Cwbvh {
    primitives: Primitives,
    hierarchy: CwBvh,
    /// Ids by the hierarchy's numbers.
    ids: Vec<u32>,
    isa: Isa,
}

/// The box of a primitive, widened by the error of hits.
struct Widened(Aabb);

impl Boundable for Widened {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

/// The best hit so far: t, u, v, and the id.
type Best = Option<(TriangleHit, u32)>;

impl SpatialIndex for Cwbvh {
    type Geometry = Primitives;
    type Scratch = ();

    fn build(primitives: Primitives, BuildOptions { isa, .. }: BuildOptions) -> Self {
        let all = 0..primitives.len() as u32;
        let ids: Vec<u32> = all.filter(|&id| can_be_hit(&primitives, id)).collect();
        let all = primitives.all_bounds();
        let size = all.min.abs().max(all.max.abs()).max_element();
        let error = Vec3A::splat(2.0 * POSITION_ERROR * size);
        let boxes: Vec<Widened> = ids
            .iter()
            .map(|&id| primitives.bounds(id))
            .map(|b| Widened(Aabb::new(Vec3A::from(b.min) - error, Vec3A::from(b.max) + error)))
            .collect();
        let hierarchy = if boxes.is_empty() {
            CwBvh::default()
        } else {
            let mut time = Duration::ZERO;
            build_cwbvh(&boxes, BvhBuildParams::medium_build(), &mut time)
        };
        Self { primitives, hierarchy, ids, isa }
    }

    #[inline]
    fn geometry(&self) -> &Primitives {
        &self.primitives
    }

    fn overhead(&self) -> usize {
        size_of_val(self.hierarchy.nodes.as_slice())
            + size_of_val(self.hierarchy.primitive_indices.as_slice())
            + size_of_val(self.ids.as_slice())
    }

    fn intersect(
        &self,
        rays: &Rays,
        coherence: Coherence,
        hits: &mut Hits,
        (): &mut (),
    ) -> Coherence {
        for i in 0..rays.len() {
            if let Some((hit, id)) = self.trace(rays, i, false) {
                (hits.t[i], hits.u[i], hits.v[i]) = (hit.t, hit.u, hit.v);
                hits.primitive[i] = id;
            }
        }
        coherence
    }

    fn occluded(
        &self,
        rays: &Rays,
        coherence: Coherence,
        blocked: &mut [bool],
        (): &mut (),
    ) -> Coherence {
        for (i, blocked) in blocked.iter_mut().enumerate().take(rays.len()) {
            *blocked = self.trace(rays, i, true).is_some();
        }
        coherence
    }
}

impl Cwbvh {
    fn trace(&self, rays: &Rays, i: usize, any: bool) -> Best {
        let (origin, direction, t_max) = (rays.origin(i), rays.direction(i), rays.t_max[i]);
        if self.ids.is_empty() || t_max.is_nan() || t_max <= 0.0 {
            return None;
        }
        // The library takes components below 2^-23 for 0: the largest is brought near 1.
        let scale = power_of_two_near(direction.abs().max_element());
        let ray = Ray::new(origin.into(), (direction / scale).into(), 0.0, t_max * scale);
        let single = Single::new(origin, direction, self.isa);
        let mut best: Best = None;
        let test = |number: usize| {
            let index = self.hierarchy.primitive_indices[number] as usize;
            let id = self.ids[index];
            let (limit, lowest) = best.map_or((t_max, 0), |(hit, id)| (hit.t, id));
            // A hit as near as the best counts if its id is lower.
            let limit = if id < lowest { limit.next_up() } else { limit };
            let hit = single.test(&self.primitives, id, limit)?;
            best = Some((hit, id));
            Some(hit.t.next_up() * scale)
        };
        self.walk(ray, any, test);
        best
    }

    /// Calls `test` with the primitives on a ray's way; it returns the ray's new end.
    fn walk(&self, ray: Ray, any: bool, mut test: impl FnMut(usize) -> Option<f32>) {
        let mut test = |_: &Ray, number: usize| test(number).unwrap_or(f32::INFINITY);
        if any {
            self.hierarchy.ray_traverse_miss(ray, test);
        } else {
            self.hierarchy.ray_traverse(ray, &mut RayHit::none(), &mut test);
        }
    }
}

/// The power of two at or below a positive number, kept away from both ends of the range.
fn power_of_two_near(x: f32) -> f32 {
    f32::from_bits(x.clamp(1e-30, 1e30).to_bits() & 0xff << 23)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use rand::{RngExt, SeedableRng, rngs::StdRng};

    use super::*;
    use crate::primitives::{Curved, Triangle};
    use crate::rays::Coherence;
    use crate::structure::{Accelerator, Scratch, Structure};

    #[test]
    fn hits_are_those_of_brute_force() {
        let mut rng = StdRng::seed_from_u64(3);
        let mut vector = |scale: f32| {
            Vec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0) * scale))
        };
        let mut triangles: Vec<Triangle> = Vec::new();
        for _ in 0..300 {
            let p = vector(1.0);
            triangles.push([p, p + vector(0.3), p + vector(0.3)]);
        }
        triangles.extend_from_within(..50);
        triangles.push([Vec3::X; 3]);
        let curved = (0..20).map(|_| Curved::Sphere { center: vector(1.0), radius: 0.1 }).collect();
        let primitives = Primitives { triangles, curved };
        let mut rays = Rays::default();
        for i in 0..20_000 {
            let length = [1.0, 1e-9, 1e9][i % 3];
            let t_max = if i % 4 == 0 { 0.7 / length } else { f32::INFINITY };
            rays.push(vector(1.5), vector(1.0) * length, t_max);
        }
        for isa in Isa::available() {
            let ask = |accelerator| {
                let structure = Structure::build(accelerator, primitives.clone(), isa);
                let (mut hits, mut blocked) = (Hits::default(), vec![]);
                let mut scratch = Scratch::default();
                structure.intersect(&rays, Coherence::Incoherent, &mut hits, &mut scratch);
                structure.occluded(&rays, Coherence::Incoherent, &mut blocked, &mut scratch);
                (hits.t, hits.u, hits.v, hits.primitive, blocked)
            };
            assert!(ask(Accelerator::Cwbvh) == ask(Accelerator::None));
        }
        let nothing = Structure::build(Accelerator::Cwbvh, Primitives::default(), Isa::Portable);
        let mut hits = Hits::default();
        nothing.intersect(&rays, Coherence::Incoherent, &mut hits, &mut Scratch::default());
        assert!(hits.primitive.iter().all(|&id| id == crate::NO_HIT));
    }
}
