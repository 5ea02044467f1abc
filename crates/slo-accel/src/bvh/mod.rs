//! A bounding volume hierarchy of eight children to a node, traced in streams of many rays.
//!
//! Built by binned SAH (`binary`), with spatial splits on request (`spatial`), collapsed by dynamic
//! programming (`plan`, `collapse`).
//! Leaves hold the triangles themselves, in blocks of up to four as rows of coordinates: they are
//! the only copy, found again by id through a table; a triangle that was cut may be in several.

mod binary;
mod bins;
mod boxes;
mod careful;
mod collapse;
mod few;
mod layout;
#[cfg_attr(not(target_arch = "x86_64"), allow(dead_code))]
mod packet;
mod plan;
mod ray;
mod spatial;
mod steps;
mod stream;
#[cfg(test)]
mod tests;
#[cfg(target_arch = "x86_64")]
mod x86;

use rayon::prelude::*;

use self::binary::{BinaryTree, extent};
use self::boxes::{Box8, Reference};
use self::collapse::Wide;
use self::layout::{Child, Corners, Node, Place};
use self::ray::{Prepared, Ray};
use self::steps::Portable;
use self::stream::Query;
use super::pages::Array;
use super::simd::{SetLanes, lanes_of, store_hits};
use super::{BuildOptions, Coherence, Curved, Hits, Isa, Primitives, Rays, Triangle, triangle};
use crate::math::Bounds;

/// Hierarchies of more bytes are far away: most of one is in no cache of one core.
const FAR: usize = 48 << 20;

/// A bounding volume hierarchy.
#[derive(Debug)]
pub struct Bvh {
    nodes: Array<Node>,
    corners: Corners,
    /// Where each triangle is first, by id.
    places: Vec<Place>,
    curved: Vec<Curved>,
    bounds: Bounds,
    /// Entries that a ray's stack needs.
    stack: usize,
    isa: Isa,
    /// Whether tame rays stay tame here.
    is_tame: bool,
    /// Whether its nodes are far away, beyond [`FAR`].
    is_far: bool,
}

/// Working memory of queries.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    stream: stream::Stream,
}

impl Bvh {
    /// Builds the hierarchy, on all threads of the current rayon pool; it is the same for any
    /// number of them.
    pub fn build(primitives: Primitives, options: impl Into<BuildOptions>) -> Self {
        let BuildOptions { isa, spatial_splits } = options.into();
        let triangle_count = primitives.triangles.len();
        let (references, left_out, extent) = references(&primitives);
        let bounds =
            left_out.iter().fold(extent[0].bounds(), |all, &id| all.union(primitives.bounds(id)));
        let left_out = &left_out[..left_out.partition_point(|&id| (id as usize) < triangle_count)];
        let tree = match spatial_splits {
            true => spatial::build(references, extent, &primitives.triangles, isa),
            false => BinaryTree::build(references, extent, triangle_count as u32, isa),
        };
        let wide = collapse::collapse(tree, &primitives.triangles, left_out);
        let Wide { nodes, corners, places, depth } = wide;
        let largest = bounds.min.abs().max(bounds.max.abs()).max_element();
        let is_tame = largest <= ray::TAME_COORDINATE;
        let stack = stream::stack_size(depth);
        let curved = primitives.curved;
        let is_far = false;
        let mut bvh = Self { nodes, corners, places, curved, bounds, stack, isa, is_tame, is_far };
        bvh.is_far = bvh.memory() > FAR;
        bvh
    }

    pub(super) fn triangle_count(&self) -> usize {
        self.places.len()
    }

    #[inline]
    pub(super) fn triangle(&self, id: u32) -> Triangle {
        let place = self.places[id as usize];
        self.corners.triangle(place.slot(), place.count(), place.lane())
    }

    pub(super) fn curved(&self) -> &[Curved] {
        &self.curved
    }

    pub(super) fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Bytes held, geometry included.
    pub(super) fn memory(&self) -> usize {
        size_of_val(&*self.nodes)
            + size_of_val(self.corners.rows())
            + size_of_val(self.places.as_slice())
            + size_of_val(self.curved.as_slice())
    }

    pub(super) fn intersect(
        &self,
        rays: &Rays,
        coherence: Coherence,
        hits: &mut Hits,
        scratch: &mut Scratch,
    ) -> Coherence {
        self.run(rays, coherence, &mut Closest { hits }, scratch)
    }

    pub(super) fn occluded(
        &self,
        rays: &Rays,
        coherence: Coherence,
        blocked: &mut [bool],
        scratch: &mut Scratch,
    ) -> Coherence {
        self.run(rays, coherence, &mut Any { blocked }, scratch)
    }

    fn run<Q: Query>(
        &self,
        rays: &Rays,
        coherence: Coherence,
        query: &mut Q,
        scratch: &mut Scratch,
    ) -> Coherence {
        if self.nodes.is_empty() {
            return coherence;
        }
        let stream = &mut scratch.stream;
        // SAFETY: the set is one that the CPU has.
        unsafe {
            match (self.isa, self.is_far) {
                #[cfg(target_arch = "x86_64")]
                (Isa::Avx512, false) => {
                    stream_avx512::<Q, false>(self, rays, coherence, query, stream)
                }
                #[cfg(target_arch = "x86_64")]
                (Isa::Avx512, true) => {
                    stream_avx512::<Q, true>(self, rays, coherence, query, stream)
                }
                #[cfg(target_arch = "x86_64")]
                (Isa::Avx2, false) => stream_avx2::<Q, false>(self, rays, coherence, query, stream),
                #[cfg(target_arch = "x86_64")]
                (Isa::Avx2, true) => stream_avx2::<Q, true>(self, rays, coherence, query, stream),
                _ => stream::trace::<Portable, Q>(self, rays, coherence, query, stream),
            }
        }
    }

    /// Tests a curved surface.
    fn test_curved(&self, rays: &Rays, child: Child, ray: &mut Ray) {
        let index = child.index();
        let i = ray.index as usize;
        let hit = self.curved[index].intersect(rays.origin(i), rays.direction(i), ray.t.next_up());
        if let Some((t, part)) = hit {
            ray.offer(t, part.to_u(), 0.0, (self.triangle_count() + index) as u32);
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512dq,avx512vl")]
unsafe fn stream_avx512<Q: Query, const FAR: bool>(
    bvh: &Bvh,
    rays: &Rays,
    coherence: Coherence,
    query: &mut Q,
    stream: &mut stream::Stream,
) -> Coherence {
    // SAFETY: the caller's.
    unsafe { stream::trace::<x86::Avx512<FAR>, Q>(bvh, rays, coherence, query, stream) }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
unsafe fn stream_avx2<Q: Query, const FAR: bool>(
    bvh: &Bvh,
    rays: &Rays,
    coherence: Coherence,
    query: &mut Q,
    stream: &mut stream::Stream,
) -> Coherence {
    // SAFETY: the caller's.
    unsafe { stream::trace::<x86::Avx2<FAR>, Q>(bvh, rays, coherence, query, stream) }
}

/// Primitives that one task makes references to.
const TASK: usize = 1 << 13;

/// Boxes of everything that can be hit, the ids of what can not, and the [`extent`].
fn references(primitives: &Primitives) -> (Vec<Reference>, Vec<u32>, [Box8; 2]) {
    let is_hollow = |id: u32, bounds: &Bounds| {
        let triangle = primitives.triangles.get(id as usize);
        triangle.is_some_and(triangle::is_degenerate) || bounds.is_empty()
    };
    let mut references: Vec<Reference> = (0..primitives.len() as u32)
        .into_par_iter()
        .map(|id| (id, primitives.bounds(id)))
        .map(|(id, bounds)| match is_hollow(id, &bounds) {
            true => Reference::NONE,
            false => Reference::new(bounds, id),
        })
        .collect();
    let hollow = |(id, r): (usize, &Reference)| r.is_none().then_some(id as u32);
    let left_out: Vec<u32> = references.par_iter().enumerate().filter_map(hollow).collect();
    if !left_out.is_empty() {
        references.retain(|r| !r.is_none());
    }
    let extents: Vec<_> = references.par_chunks(TASK).map(extent).collect();
    let extent = extents.iter().fold([Box8::EMPTY; 2], |[all, centers], part| {
        [all.union(&part[0]), centers.union(&part[1])]
    });
    (references, left_out, extent)
}

/// The first hit of each ray.
struct Closest<'a> {
    hits: &'a mut Hits,
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
struct Any<'a> {
    blocked: &'a mut [bool],
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
