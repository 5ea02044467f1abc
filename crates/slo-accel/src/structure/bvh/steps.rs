//! The two steps of a ray, boxes and triangles, in plain Rust: the reference of the others.

use super::layout::{BLOCK, Child, Node, WIDTH, rows_of, triangle_at};
use super::ray::{Prepared, Ray};
use crate::primitives::triangle;
use crate::rays::LANES;
use crate::structure::shared::order::{self, Choosing};

/// The steps of a stream, for one instruction set. All sets find the same hits; one may enter a box
/// that another misses if no hit depends on it.
pub(super) trait Steps {
    /// How rays are chosen from a batch.
    type Choosing: Choosing;

    /// Whether boxes and corners move.
    const MOVES: bool;

    /// Rows of a block.
    const ROWS: usize = rows_of(Self::MOVES);

    /// Whether it is for hierarchies that are mostly outside the caches of a core.
    const IS_FAR: bool = false;

    /// Writes the children whose boxes the ray enters up to its best hit, from far to near, with
    /// the distances at which it enters, and returns their number; of the children only those in
    /// `among`, bit `s` for the one that is `s`-th from the far end. Eight entries of both arrays
    /// may be overwritten.
    ///
    /// # Safety
    /// The CPU has the instruction set; there is such a node; both arrays are writable for eight
    /// entries.
    unsafe fn children(
        node: *const Node,
        ray: &Ray,
        among: u8,
        ts: *mut f32,
        children: *mut Child,
    ) -> usize;

    /// Drops the entries of a stack of `len` whose distance is more than `t`; returns the number of
    /// entries kept.
    ///
    /// # Safety
    /// The CPU has the instruction set; both arrays have that many entries and eight more.
    #[inline(always)]
    unsafe fn cull(ts: *mut f32, children: *mut Child, len: usize, t: f32) -> usize {
        let mut kept = 0;
        for i in 0..len {
            // SAFETY: both are entries.
            unsafe {
                let near = *ts.add(i);
                *ts.add(kept) = near;
                *children.add(kept) = *children.add(i);
                kept += usize::from(near <= t);
            }
        }
        kept
    }

    /// Number of blocks that [`blocks`](Self::blocks) tests at once.
    const BLOCKS: usize;

    /// Which triangles of the first [`BLOCKS`](Self::BLOCKS) blocks their rays hit, and where: no
    /// farther than at `ray.t`, or before it if `any` hit will do. Bit `lane` of the result is set
    /// if lane `lane` of `hits` counts; a block has [`BLOCK`] lanes.
    ///
    /// # Safety
    /// The CPU has the instruction set; all are blocks and rays, and 4 elements beyond a block's
    /// rows are readable.
    unsafe fn blocks(meetings: &[Meeting; MOST_BLOCKS], any: bool, hits: &mut BlockHits) -> u32;

    /// Writes sixteen rays, without stacks.
    ///
    /// # Safety
    /// The CPU has the instruction set.
    #[inline(always)]
    unsafe fn deal(prepared: &Prepared, rays: &mut [Ray; LANES]) {
        for (lane, ray) in rays.iter_mut().enumerate() {
            *ray = Ray::new(prepared, lane);
        }
    }
}

/// Most blocks that are tested at once.
pub(super) const MOST_BLOCKS: usize = LANES / BLOCK;

/// A block of triangles, by its first row, and a ray that may hit some of them.
#[derive(Clone, Copy)]
pub(super) struct Meeting {
    pub(super) block: *const f32,
    pub(super) count: usize,
    pub(super) ray: *mut Ray,
}

/// Where triangles of blocks are hit.
#[derive(Default)]
pub(super) struct BlockHits {
    pub(super) t: [f32; LANES],
    /// Weights of the second and third corner, and what to divide them by.
    pub(super) weights: [[f32; LANES]; 2],
    pub(super) sum: [f32; LANES],
}

impl BlockHits {
    /// t, u and v of a lane.
    #[inline(always)]
    pub(super) fn get(&self, lane: usize) -> [f32; 3] {
        let lane = lane % LANES;
        let sum = self.sum[lane];
        [self.t[lane], self.weights[0][lane] / sum, self.weights[1][lane] / sum]
    }
}

/// Plain Rust.
pub(super) struct Portable<const MOVES: bool>;

impl<const MOVES: bool> Steps for Portable<MOVES> {
    type Choosing = order::Portable;

    const MOVES: bool = MOVES;

    #[inline(always)]
    unsafe fn children(
        node: *const Node,
        ray: &Ray,
        among: u8,
        ts: *mut f32,
        children: *mut Child,
    ) -> usize {
        // SAFETY: the caller's; a node whose boxes move is followed by how they do.
        let (node, changes) = unsafe { (&*node, &*node.add(usize::from(MOVES))) };
        let mut enters = [f32::INFINITY; WIDTH];
        for (child, enter) in enters.iter_mut().enumerate() {
            let (mut near, mut far) = (0.0f32, ray.t);
            for axis in 0..3 {
                let negative = (ray.entries[axis] >> 5 & 1) as usize;
                let mut entry = node.planes[2 * axis + negative][child];
                let mut exit = node.planes[2 * axis + 1 - negative][child];
                if MOVES {
                    entry += changes.planes[2 * axis + negative][child] * ray.time;
                    exit += changes.planes[2 * axis + 1 - negative][child] * ray.time;
                }
                near = near.max(entry * ray.inverse[axis] - ray.near[axis]);
                far = far.min(exit * ray.inverse[axis] - ray.far[axis]);
            }
            if near <= far {
                *enter = near;
            }
        }
        let mut count = 0;
        for (s, word) in node.order.into_iter().enumerate() {
            let child = (word >> ray.order_shift & 7) as usize;
            if enters[child] < f32::INFINITY && among >> s & 1 == 1 {
                // SAFETY: at most eight entries are written.
                unsafe {
                    *ts.add(count) = enters[child];
                    *children.add(count) = node.children[child];
                }
                count += 1;
            }
        }
        count
    }

    const BLOCKS: usize = 1;

    #[inline(always)]
    unsafe fn blocks(meetings: &[Meeting; MOST_BLOCKS], any: bool, hits: &mut BlockHits) -> u32 {
        let Meeting { block, count, ray } = meetings[0];
        // SAFETY: the caller's.
        let ray = unsafe { &*ray };
        let sheared = ray.sheared();
        let t_max = if any { ray.t } else { ray.t.next_up() };
        let mut set = 0;
        for lane in 0..count {
            // SAFETY: the caller's.
            let triangle = unsafe { triangle_at(block, count, lane, MOVES.then_some(ray.time)) };
            if let Some(hit) = triangle::intersect(&sheared, &triangle, t_max) {
                hits.t[lane] = hit.t;
                (hits.weights[0][lane], hits.weights[1][lane]) = (hit.u, hit.v);
                hits.sum[lane] = 1.0;
                set |= 1 << lane;
            }
        }
        set
    }
}
