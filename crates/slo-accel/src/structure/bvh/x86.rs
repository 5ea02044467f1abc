//! The steps of a ray on AVX2 and AVX-512.

use std::arch::x86_64::*;

use super::hierarchy::Bvh;
use super::layout::{Child, Node};
use super::packet::{self, Beam, PacketSteps, Packets, Surroundings};
use super::quads::blocks;
use super::query::Query;
use super::ray::{Prepared, Ray};
use super::steps::{BlockHits, MOST_BLOCKS, Meeting, Steps};
use super::stream::{self, Stream};
use crate::isa::Isa;
use crate::rays::{Coherence, LANES, Rays};
use crate::simd::sets::LANES_OF;
use crate::structure::shared::order::x86 as order;

/// AVX2 with fused multiply-add.
pub(super) struct Avx2<const FAR: bool, const MOVES: bool>;

/// AVX-512 on 8 lanes.
pub(super) struct Avx512<const FAR: bool, const MOVES: bool>;

/// Traces a batch of rays, as [`stream::trace`].
///
/// # Safety
/// The hierarchy's set is one of these two, and the CPU has it.
pub(super) unsafe fn trace<Q: Query, const MOVES: bool>(
    bvh: &Bvh,
    batch: (&Rays, &[f32]),
    coherence: Coherence,
    query: &mut Q,
    stream: &mut Stream,
) -> Coherence {
    // SAFETY: the caller's.
    unsafe {
        match (bvh.isa, bvh.is_far) {
            (Isa::Avx512, false) => {
                trace_avx512::<Q, false, MOVES>(bvh, batch, coherence, query, stream)
            }
            (Isa::Avx512, true) => {
                trace_avx512::<Q, true, MOVES>(bvh, batch, coherence, query, stream)
            }
            (_, false) => trace_avx2::<Q, false, MOVES>(bvh, batch, coherence, query, stream),
            (_, true) => trace_avx2::<Q, true, MOVES>(bvh, batch, coherence, query, stream),
        }
    }
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512dq,avx512vl")]
unsafe fn trace_avx512<Q: Query, const FAR: bool, const MOVES: bool>(
    bvh: &Bvh,
    batch: (&Rays, &[f32]),
    coherence: Coherence,
    query: &mut Q,
    stream: &mut Stream,
) -> Coherence {
    // SAFETY: the caller's.
    unsafe { stream::trace::<Avx512<FAR, MOVES>, Q>(bvh, batch, coherence, query, stream) }
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
unsafe fn trace_avx2<Q: Query, const FAR: bool, const MOVES: bool>(
    bvh: &Bvh,
    batch: (&Rays, &[f32]),
    coherence: Coherence,
    query: &mut Q,
    stream: &mut Stream,
) -> Coherence {
    // SAFETY: the caller's.
    unsafe { stream::trace::<Avx2<FAR, MOVES>, Q>(bvh, batch, coherence, query, stream) }
}

/// Distances where a ray enters and leaves the eight boxes.
///
/// # Safety
/// The CPU has AVX2 and FMA; there is such a node.
#[inline(always)]
unsafe fn slabs<const MOVES: bool>(node: *const Node, ray: &Ray) -> (__m256, __m256) {
    let planes = node.cast::<u8>();
    let slab = |planes, inverse: &f32, offset: &f32| {
        // SAFETY: see below.
        unsafe {
            let planes = planes_at::<MOVES>(planes, ray.time);
            _mm256_fmsub_ps(planes, _mm256_broadcast_ss(inverse), _mm256_broadcast_ss(offset))
        }
    };
    // SAFETY: the offsets lie within the planes, which are aligned to 32 bytes.
    unsafe {
        let (x, y, z) = (ray.entries[0] as usize, ray.entries[1] as usize, ray.entries[2] as usize);
        let near = _mm256_max_ps(
            _mm256_max_ps(
                slab(planes.add(x), &ray.inverse[0], &ray.near[0]),
                slab(planes.add(y), &ray.inverse[1], &ray.near[1]),
            ),
            _mm256_max_ps(slab(planes.add(z), &ray.inverse[2], &ray.near[2]), _mm256_setzero_ps()),
        );
        let far = _mm256_min_ps(
            _mm256_min_ps(
                slab(planes.add(x ^ 32), &ray.inverse[0], &ray.far[0]),
                slab(planes.add(y ^ 32), &ray.inverse[1], &ray.far[1]),
            ),
            _mm256_min_ps(
                slab(planes.add(z ^ 32), &ray.inverse[2], &ray.far[2]),
                _mm256_broadcast_ss(&ray.t),
            ),
        );
        (near, far)
    }
}

/// Eight planes, at a time if they move.
///
/// # Safety
/// The CPU has AVX2 and FMA; there are eight planes of a node, aligned to 32 bytes.
#[inline(always)]
unsafe fn planes_at<const MOVES: bool>(planes: *const u8, time: f32) -> __m256 {
    // SAFETY: the caller's; a node whose boxes move is followed by how they do.
    unsafe {
        let start = _mm256_load_ps(planes.cast());
        if MOVES {
            let change = _mm256_load_ps(planes.add(size_of::<Node>()).cast());
            _mm256_fmadd_ps(change, _mm256_set1_ps(time), start)
        } else {
            start
        }
    }
}

/// Which child is the n-th from the far end, in the low three bits of each lane.
///
/// # Safety
/// The CPU has AVX2.
#[inline(always)]
unsafe fn shifted(node: &Node, shift: u32) -> __m256i {
    // SAFETY: the words are aligned to 32 bytes.
    unsafe {
        let words = _mm256_load_si256(node.order.as_ptr().cast());
        _mm256_srlv_epi32(words, _mm256_set1_epi32(shift as i32))
    }
}

/// A mask of the boxes that some ray of a beam may enter before its end; a child's number is its
/// lane.
///
/// # Safety
/// The CPU has AVX2 and FMA.
#[inline(always)]
unsafe fn met_by<const MOVES: bool>(node: *const Node, beam: &Beam) -> __m256 {
    let planes = node.cast::<u8>();
    // SAFETY: the offsets lie within the planes, which are aligned to 32 bytes.
    unsafe {
        let mut near = _mm256_setzero_ps();
        let mut far = _mm256_set1_ps(beam.t_max);
        for axis in 0..3 {
            let entry = beam.entries[axis] as usize;
            let (least, offset) = (beam.least[axis], beam.near[axis]);
            let enter = |time| {
                let plane = planes_at::<MOVES>(planes.add(entry), time);
                _mm256_fmsub_ps(plane, _mm256_set1_ps(least), _mm256_set1_ps(offset))
            };
            let (most, offset) = (beam.most[axis], beam.far[axis]);
            let leave = |time| {
                let plane = planes_at::<MOVES>(planes.add(entry ^ 32), time);
                _mm256_fmsub_ps(plane, _mm256_set1_ps(most), _mm256_set1_ps(offset))
            };
            let [first, last] = beam.times;
            let (mut enters, mut leaves) = (enter(first), leave(first));
            if MOVES {
                // A plane that moves lies between where it is at the first time and at the last.
                enters = _mm256_min_ps(enters, enter(last));
                leaves = _mm256_max_ps(leaves, leave(last));
            }
            near = _mm256_max_ps(near, enters);
            far = _mm256_min_ps(far, leaves);
        }
        _mm256_cmp_ps::<_CMP_LE_OQ>(near, far)
    }
}

/// Bits of the boxes that some ray of a beam may enter; the nearest child's is the lowest.
///
/// # Safety
/// The CPU has AVX2 and FMA.
#[inline(always)]
unsafe fn may_enter<const MOVES: bool>(node: *const Node, beam: &Beam) -> u32 {
    // SAFETY: the caller's.
    unsafe {
        let met = met_by::<MOVES>(node, beam);
        let order = shifted(&*node, beam.order_shift);
        let order = _mm256_permutevar8x32_epi32(order, _mm256_setr_epi32(7, 6, 5, 4, 3, 2, 1, 0));
        _mm256_movemask_ps(_mm256_permutevar8x32_ps(met, order)) as u32
    }
}

/// The children of a node from far to near: the distances at which a ray enters them, their names,
/// and which of those in `among` it enters.
///
/// # Safety
/// The CPU has AVX-512.
#[inline(always)]
unsafe fn sorted<const MOVES: bool>(
    node: *const Node,
    ray: &Ray,
    among: u8,
) -> (__m256, __m256i, u8) {
    // SAFETY: the caller's.
    unsafe {
        let (near, far) = slabs::<MOVES>(node, ray);
        let node = &*node;
        let order = shifted(node, ray.order_shift);
        let near = _mm256_permutevar8x32_ps(near, order);
        let far = _mm256_permutevar8x32_ps(far, order);
        let names = _mm256_load_si256(node.children.as_ptr().cast());
        let names = _mm256_permutevar8x32_epi32(names, order);
        (near, names, _mm256_mask_cmp_ps_mask::<_CMP_LE_OQ>(among, near, far))
    }
}

impl<const FAR: bool, const MOVES: bool> PacketSteps for Avx512<FAR, MOVES> {
    type Lanes = __m512;

    #[inline(always)]
    unsafe fn may_enter(node: *const Node, beam: &Beam) -> u32 {
        // SAFETY: the caller's.
        unsafe { may_enter::<MOVES>(node, beam) }
    }

    #[inline(always)]
    unsafe fn walk<Q: Query>(
        around: &mut Surroundings,
        prepared: &Prepared,
        base: usize,
        set: u32,
        query: &mut Q,
    ) {
        // SAFETY: the caller's.
        unsafe { walk_avx512::<FAR, MOVES, Q>(around, prepared, base, set, query) }
    }
}

/// # Safety
/// As [`packet::walk`].
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512dq,avx512vl")]
#[inline(never)]
unsafe fn walk_avx512<const FAR: bool, const MOVES: bool, Q: Query>(
    around: &mut Surroundings,
    prepared: &Prepared,
    base: usize,
    set: u32,
    query: &mut Q,
) {
    // SAFETY: the caller's.
    unsafe { packet::walk::<Avx512<FAR, MOVES>, Q>(around, prepared, base, set, query) }
}

impl<const FAR: bool, const MOVES: bool> PacketSteps for Avx2<FAR, MOVES> {
    type Lanes = __m256;

    #[inline(always)]
    unsafe fn may_enter(node: *const Node, beam: &Beam) -> u32 {
        // SAFETY: the caller's.
        unsafe { may_enter::<MOVES>(node, beam) }
    }

    #[inline(always)]
    unsafe fn walk<Q: Query>(
        around: &mut Surroundings,
        prepared: &Prepared,
        base: usize,
        set: u32,
        query: &mut Q,
    ) {
        // SAFETY: the caller's.
        unsafe { walk_avx2::<FAR, MOVES, Q>(around, prepared, base, set, query) }
    }
}

/// # Safety
/// As [`packet::walk`].
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
#[inline(never)]
unsafe fn walk_avx2<const FAR: bool, const MOVES: bool, Q: Query>(
    around: &mut Surroundings,
    prepared: &Prepared,
    base: usize,
    set: u32,
    query: &mut Q,
) {
    // SAFETY: the caller's.
    unsafe { packet::walk::<Avx2<FAR, MOVES>, Q>(around, prepared, base, set, query) }
}

impl<const FAR: bool, const MOVES: bool> Packets for Avx512<FAR, MOVES> {
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

impl<const FAR: bool, const MOVES: bool> Steps for Avx512<FAR, MOVES> {
    type Choosing = order::Avx512;

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
            let (near, names, entered) = sorted::<MOVES>(node, ray, among);
            _mm256_storeu_ps(ts, _mm256_maskz_compress_ps(entered, near));
            _mm256_storeu_si256(children.cast(), _mm256_maskz_compress_epi32(entered, names));
            entered.count_ones() as usize
        }
    }

    #[inline(always)]
    unsafe fn cull(ts: *mut f32, children: *mut Child, len: usize, t: f32) -> usize {
        let mut kept = 0;
        // SAFETY: what is read and written beyond the entries is among the eight behind them.
        unsafe {
            for i in (0..len).step_by(8) {
                let near = _mm256_loadu_ps(ts.add(i));
                let names = _mm256_loadu_si256(children.add(i).cast());
                let present = (1u32 << (len - i).min(8)) - 1;
                let t = _mm256_set1_ps(t);
                let kept_here = _mm256_mask_cmp_ps_mask::<_CMP_LE_OQ>(present as u8, near, t);
                _mm256_storeu_ps(ts.add(kept), _mm256_maskz_compress_ps(kept_here, near));
                let names = _mm256_maskz_compress_epi32(kept_here, names);
                _mm256_storeu_si256(children.add(kept).cast(), names);
                kept += kept_here.count_ones() as usize;
            }
        }
        kept
    }

    #[inline(always)]
    unsafe fn deal(prepared: &Prepared, rays: &mut [Ray; LANES]) {
        // SAFETY: the caller's.
        unsafe { Ray::deal::<__m512, MOVES>(prepared, rays) }
    }

    const BLOCKS: usize = 4;

    #[inline(always)]
    unsafe fn blocks(meetings: &[Meeting; MOST_BLOCKS], any: bool, hits: &mut BlockHits) -> u32 {
        // SAFETY: the caller's.
        unsafe { blocks::<__m512, MOVES>(meetings, any, hits) }
    }
}

impl<const FAR: bool, const MOVES: bool> Packets for Avx2<FAR, MOVES> {
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

impl<const FAR: bool, const MOVES: bool> Steps for Avx2<FAR, MOVES> {
    type Choosing = order::Avx2;

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
            let entered = _mm256_cmp_ps::<_CMP_LE_OQ>(near, far);
            let order = shifted(node, ray.order_shift);
            let set = _mm256_movemask_ps(_mm256_permutevar8x32_ps(entered, order)) as usize;
            let set = set & usize::from(among);
            let lanes = _mm_loadl_epi64(LANES_OF[set & 255].as_ptr().cast());
            let order = _mm256_permutevar8x32_epi32(order, _mm256_cvtepu8_epi32(lanes));
            let names = _mm256_load_si256(node.children.as_ptr().cast());
            _mm256_storeu_ps(ts, _mm256_permutevar8x32_ps(near, order));
            _mm256_storeu_si256(children.cast(), _mm256_permutevar8x32_epi32(names, order));
            set.count_ones() as usize
        }
    }

    #[inline(always)]
    unsafe fn deal(prepared: &Prepared, rays: &mut [Ray; LANES]) {
        // SAFETY: the caller's.
        unsafe { Ray::deal::<__m256, MOVES>(prepared, rays) }
    }

    const BLOCKS: usize = 2;

    #[inline(always)]
    unsafe fn blocks(meetings: &[Meeting; MOST_BLOCKS], any: bool, hits: &mut BlockHits) -> u32 {
        // SAFETY: the caller's.
        unsafe { blocks::<__m256, MOVES>(meetings, any, hits) }
    }
}
