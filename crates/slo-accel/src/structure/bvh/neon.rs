//! The steps of a ray on NEON.

use std::arch::aarch64::*;

use super::hierarchy::Bvh;
use super::layout::{Child, Node};
use super::packet::{self, Beam, PacketSteps, Packets, Surroundings};
use super::quads::blocks;
use super::query::Query;
use super::ray::{Prepared, Ray};
use super::steps::{BlockHits, MOST_BLOCKS, Meeting, Steps};
use super::stream::{self, Stream};
use crate::rays::{Coherence, LANES, Rays};
use crate::simd::Lanes;
use crate::simd::neon::{Eight, Places, lanes_in, narrow, set_of_bytes};
use crate::structure::shared::order::neon as order;

/// NEON on 8 lanes.
pub(super) struct Neon<const FAR: bool, const MOVES: bool>;

/// Traces a batch of rays, as [`stream::trace`].
pub(super) fn trace<Q: Query, const MOVES: bool>(
    bvh: &Bvh,
    batch: (&Rays, &[f32]),
    coherence: Coherence,
    query: &mut Q,
    stream: &mut Stream,
) -> Coherence {
    // SAFETY: every AArch64 CPU has the instructions.
    unsafe {
        if bvh.is_far {
            stream::trace::<Neon<true, MOVES>, Q>(bvh, batch, coherence, query, stream)
        } else {
            stream::trace::<Neon<false, MOVES>, Q>(bvh, batch, coherence, query, stream)
        }
    }
}

/// Distances where a ray enters and leaves the eight boxes.
///
/// # Safety
/// There is such a node.
#[inline(always)]
unsafe fn slabs<const MOVES: bool>(node: *const Node, ray: &Ray) -> (Eight, Eight) {
    let planes = node.cast::<u8>();
    // SAFETY: the offsets lie within the planes; each three numbers of a ray are followed by one
    // more.
    unsafe {
        let inverse = vld1q_f32((&raw const ray.inverse).cast());
        let near = vnegq_f32(vld1q_f32((&raw const ray.near).cast()));
        let far = vnegq_f32(vld1q_f32((&raw const ray.far).cast()));
        let at = |planes| planes_at::<MOVES>(planes, ray.time);
        let (x, y, z) = (ray.entries[0] as usize, ray.entries[1] as usize, ray.entries[2] as usize);
        let enters = crossed::<0>(at(planes.add(x)), inverse, near)
            .max_number(crossed::<1>(at(planes.add(y)), inverse, near))
            .max_number(
                crossed::<2>(at(planes.add(z)), inverse, near).max_number(Eight::splat(0.0)),
            );
        let leaves = crossed::<0>(at(planes.add(x ^ 32)), inverse, far)
            .min_number(crossed::<1>(at(planes.add(y ^ 32)), inverse, far))
            .min_number(
                crossed::<2>(at(planes.add(z ^ 32)), inverse, far).min_number(Eight::splat(ray.t)),
            );
        (enters, leaves)
    }
}

/// Distances of planes across an axis.
#[inline(always)]
fn crossed<const AXIS: i32>(
    planes: Eight,
    inverse: float32x4_t,
    minus_offset: float32x4_t,
) -> Eight {
    // SAFETY: every AArch64 CPU has the instructions.
    unsafe {
        let offset = vdupq_laneq_f32::<AXIS>(minus_offset);
        Eight(
            vfmaq_laneq_f32::<AXIS>(offset, planes.0, inverse),
            vfmaq_laneq_f32::<AXIS>(offset, planes.1, inverse),
        )
    }
}

/// Eight planes, at a time if they move.
///
/// # Safety
/// There are eight planes of a node.
#[inline(always)]
unsafe fn planes_at<const MOVES: bool>(planes: *const u8, time: f32) -> Eight {
    // SAFETY: the caller's; a node whose boxes move is followed by how they do.
    unsafe {
        let start = Eight::load(planes.cast());
        if MOVES {
            let change = Eight::load(planes.add(size_of::<Node>()).cast());
            change.mul_add(Eight::splat(time), start)
        } else {
            start
        }
    }
}

/// Which child is the n-th from the far end.
#[inline(always)]
fn ordered(node: &Node, shift: u32) -> uint8x8_t {
    // SAFETY: there are eight words, and every AArch64 CPU has the instructions.
    unsafe {
        let words = Eight::load(node.order.as_ptr().cast());
        let back = vdupq_n_s32(-(shift as i32));
        let shifted = |words| vshlq_u32(vreinterpretq_u32_f32(words), back);
        vand_u8(vmovn_u16(narrow(shifted(words.0), shifted(words.1))), vdup_n_u8(7))
    }
}

/// The boxes that some ray of a beam may enter before its end, all bits in their bytes; a child's
/// number is its lane.
///
/// # Safety
/// There is such a node.
#[inline(always)]
unsafe fn met_by<const MOVES: bool>(node: *const Node, beam: &Beam) -> uint8x8_t {
    let planes = node.cast::<u8>();
    // SAFETY: the offsets lie within the planes.
    unsafe {
        let mut near = Eight::splat(0.0);
        let mut far = Eight::splat(beam.t_max);
        for axis in 0..3 {
            let entry = beam.entries[axis] as usize;
            let (least, offset) = (Eight::splat(beam.least[axis]), Eight::splat(-beam.near[axis]));
            let enter = |time| planes_at::<MOVES>(planes.add(entry), time).mul_add(least, offset);
            let (most, offset) = (Eight::splat(beam.most[axis]), Eight::splat(-beam.far[axis]));
            let leave =
                |time| planes_at::<MOVES>(planes.add(entry ^ 32), time).mul_add(most, offset);
            let [first, last] = beam.times;
            let (mut enters, mut leaves) = (enter(first), leave(first));
            if MOVES {
                // A plane that moves lies between where it is at the first time and at the last.
                enters = enters.min_number(enter(last));
                leaves = leaves.max_number(leave(last));
            }
            near = near.max_number(enters);
            far = far.min_number(leaves);
        }
        near.le_bytes(far)
    }
}

impl<const FAR: bool, const MOVES: bool> PacketSteps for Neon<FAR, MOVES> {
    type Lanes = Eight;

    #[inline(always)]
    unsafe fn may_enter(node: *const Node, beam: &Beam) -> u32 {
        // SAFETY: the caller's.
        unsafe {
            let met = met_by::<MOVES>(node, beam);
            let from_far = vtbl1_u8(met, ordered(&*node, beam.order_shift));
            set_of_bytes(vrev64_u8(from_far))
        }
    }

    #[inline(never)]
    unsafe fn walk<Q: Query>(
        around: &mut Surroundings,
        prepared: &Prepared,
        base: usize,
        set: u32,
        query: &mut Q,
    ) {
        // SAFETY: the caller's.
        unsafe { packet::walk::<Self, Q>(around, prepared, base, set, query) }
    }
}

impl<const FAR: bool, const MOVES: bool> Packets for Neon<FAR, MOVES> {
    #[inline(always)]
    unsafe fn packets<Q: Query>(
        around: &mut Surroundings,
        prepared: &Prepared,
        pending: u32,
        query: &mut Q,
    ) -> u32 {
        // SAFETY: the caller's.
        unsafe { packet::trace::<Self, Q>(around, prepared, pending, query) }
    }
}

impl<const FAR: bool, const MOVES: bool> Steps for Neon<FAR, MOVES> {
    type Choosing = order::Neon;

    const MOVES: bool = MOVES;

    const IS_FAR: bool = FAR;

    #[inline(always)]
    unsafe fn children(
        node: *const Node,
        ray: &Ray,
        among: u8,
        ts: *mut f32,
        children: *mut Child,
    ) -> usize {
        // SAFETY: the caller's.
        unsafe {
            let (near, far) = slabs::<MOVES>(node, ray);
            let node = &*node;
            let order = ordered(node, ray.order_shift);
            let set = set_of_bytes(vtbl1_u8(near.le_bytes(far), order)) & u32::from(among);
            let places = Places::of(vtbl1_u8(order, lanes_in(set)));
            places.take(near).store(ts);
            places.take(Eight::load(node.children.as_ptr().cast())).store(children.cast());
            set.count_ones() as usize
        }
    }

    #[inline(always)]
    unsafe fn deal(prepared: &Prepared, rays: &mut [Ray; LANES]) {
        // SAFETY: the caller's.
        unsafe { Ray::deal::<Eight, MOVES>(prepared, rays) }
    }

    const BLOCKS: usize = 2;

    #[inline(always)]
    unsafe fn blocks(meetings: &[Meeting; MOST_BLOCKS], any: bool, hits: &mut BlockHits) -> u32 {
        // SAFETY: the caller's.
        unsafe { blocks::<Eight, MOVES>(meetings, any, hits) }
    }
}
