//! The two questions about rays, and where the answers go.

use super::leaf::Best;
#[cfg(target_arch = "x86_64")]
use super::ray::Prepared;
use crate::rays::Hits;
#[cfg(target_arch = "x86_64")]
use crate::simd::{SetLanes, lanes_of, store_hits};

/// A question about rays.
pub(super) trait Query {
    /// Whether any hit is enough.
    const ANY: bool;

    /// Stores the hit of a ray by its index in the batch.
    fn accept(&mut self, index: usize, best: &Best);

    /// Stores the hits of a set of the prepared rays, whose first lane is `base`: t, u, v, and bits
    /// of ids.
    ///
    /// # Safety
    /// The CPU has the instructions of `L`; the rays are those of this batch.
    #[cfg(target_arch = "x86_64")]
    unsafe fn accept_lanes<L: SetLanes>(
        &mut self,
        rays: &Prepared,
        base: usize,
        set: u32,
        hits: [L; 4],
    );
}

/// The nearest hit.
pub(super) struct Nearest<'a> {
    pub(super) hits: &'a mut Hits,
}

impl Query for Nearest<'_> {
    const ANY: bool = false;

    #[inline(always)]
    fn accept(&mut self, index: usize, best: &Best) {
        self.hits.t[index] = best.t;
        self.hits.u[index] = best.u;
        self.hits.v[index] = best.v;
        self.hits.primitive[index] = best.primitive;
    }

    #[cfg(target_arch = "x86_64")]
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

/// Whether anything is hit.
pub(super) struct Blocked<'a> {
    pub(super) blocked: &'a mut [bool],
}

impl Query for Blocked<'_> {
    const ANY: bool = true;

    #[inline(always)]
    fn accept(&mut self, index: usize, _: &Best) {
        self.blocked[index] = true;
    }

    #[cfg(target_arch = "x86_64")]
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
