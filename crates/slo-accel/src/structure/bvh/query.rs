//! The two questions about rays, and where the answers go.

use super::ray::{Prepared, Ray};
use crate::rays::Hits;
use crate::simd::{SetLanes, lanes_of, store_hits};

/// A question about rays.
pub(super) trait Query {
    /// Whether any hit is enough.
    const ANY: bool;
    /// Stores the hit of a ray by its index in the batch: t, u, v, and the id.
    fn accept(&mut self, index: usize, hit: [f32; 3], primitive: u32);
    /// Stores the hits of a set of the prepared rays, whose first lane is `base`: t, u, v, and bits
    /// of ids.
    ///
    /// # Safety
    /// The CPU has the instructions of `L`; the rays are those of this batch.
    unsafe fn accept_lanes<L: SetLanes>(
        &mut self,
        rays: &Prepared,
        base: usize,
        set: u32,
        hits: [L; 4],
    );
    /// Stores the hit of a ray that is done, if it has one.
    #[inline(always)]
    fn finish(&mut self, ray: &Ray) {
        if ray.is_hit != 0 {
            self.accept(ray.index as usize, [ray.t, ray.u, ray.v], ray.primitive);
        }
    }
}

/// The first hit of each ray.
pub(super) struct Closest<'a> {
    pub(super) hits: &'a mut Hits,
}

impl Query for Closest<'_> {
    const ANY: bool = false;

    #[inline(always)]
    fn accept(&mut self, index: usize, [t, u, v]: [f32; 3], primitive: u32) {
        self.hits.t[index] = t;
        self.hits.u[index] = u;
        self.hits.v[index] = v;
        self.hits.primitive[index] = primitive;
    }

    #[inline(always)]
    unsafe fn accept_lanes<L: SetLanes>(
        &mut self,
        rays: &Prepared,
        base: usize,
        set: u32,
        hits: [L; 4],
    ) {
        let (indices, are_neighbours) = (&rays.index[base..], rays.are_neighbours);
        // SAFETY: the caller's; there is a hit for each ray of the batch.
        unsafe { store_hits(self.hits, indices, are_neighbours, set, hits) }
    }
}

/// Whether each ray is blocked.
pub(super) struct Any<'a> {
    pub(super) blocked: &'a mut [bool],
}

impl Query for Any<'_> {
    const ANY: bool = true;

    #[inline(always)]
    fn accept(&mut self, index: usize, _: [f32; 3], _: u32) {
        self.blocked[index] = true;
    }

    #[inline(always)]
    unsafe fn accept_lanes<L: SetLanes>(
        &mut self,
        rays: &Prepared,
        base: usize,
        set: u32,
        _: [L; 4],
    ) {
        for lane in lanes_of(set) {
            self.blocked[rays.index[base + lane] as usize] = true;
        }
    }
}
