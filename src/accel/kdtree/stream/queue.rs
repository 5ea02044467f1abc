//! Rays that wait to go into flight.

use std::arch::x86_64::*;

use super::{Entry, Flights, Group, ROWS, as_bits, get, get_ps, lane_numbers};
use crate::accel::LANES;
use crate::accel::kdtree::leaf::Best;
use crate::accel::kdtree::node::Node;
use crate::accel::kdtree::packet::{self, Parking};
use crate::accel::kdtree::ray::Prepared;
use crate::accel::kdtree::x86::Avx512;
use crate::accel::kdtree::{KdTree, Left, NO_HIT};
use crate::accel::order::{Sixteen, x86::Avx512 as Choices};
use crate::accel::simd::lanes_of;

/// Rays that are ready, and those that left packets.
#[derive(Debug)]
#[repr(C, align(64))]
pub(super) struct Queue {
    /// With room for a register beyond the last.
    flights: Flights<{ 2 * LANES }>,
    /// Where each stood among the sixteen that were made ready together.
    place: [u32; 2 * LANES],
    prepared: Prepared<LANES>,
    parking: Parking,
}

impl Queue {
    pub(super) const EMPTY: Self = Self {
        flights: Flights::EMPTY,
        place: [0; 2 * LANES],
        prepared: Prepared::EMPTY,
        parking: Parking::EMPTY,
    };
}

/// Rays that are not under way yet.
pub(super) struct Waiting<'a> {
    pub(super) left: Left<'a>,
    pub(super) queue: &'a mut Queue,
    /// The rays of the queue that are.
    pub(super) from: usize,
    pub(super) len: usize,
    pub(super) packets: Option<&'a mut packet::Stack>,
}

impl Waiting<'_> {
    /// Gives rays to free lanes.
    ///
    /// # Safety
    /// As [`trace`](super::trace).
    #[inline(always)]
    pub(super) unsafe fn refill<const ANY: bool>(
        &mut self,
        tree: &KdTree,
        group: &mut Group,
        mut free: u32,
        done: &mut impl FnMut(usize, &Best),
    ) {
        while free != 0 {
            if self.from == self.len {
                let Some((sixteen, count)) = self.left.take() else { return };
                // SAFETY: the caller's.
                unsafe { self.prepare::<ANY>(tree, sixteen, count, done) };
                continue;
            }
            // The lowest free lanes, as many as there are rays.
            let count = (self.len - self.from) as u32;
            // SAFETY: BMI2 comes with AVX2 in all CPUs with AVX-512.
            let lanes = unsafe { lowest(free, count) };
            // SAFETY: rows of the queue are readable for sixteen lanes from `from` on, those of
            // the group hold sixteen.
            unsafe {
                let to = (&raw mut group.flights).cast::<f32>();
                let queue = (&raw const self.queue.flights).cast::<f32>();
                for row in 0..Flights::<LANES>::ROWS {
                    let to = to.add(row * LANES);
                    let from = _mm512_loadu_ps(queue.add(row * 2 * LANES + self.from));
                    let old = _mm512_load_ps(to);
                    _mm512_store_ps(to, _mm512_mask_expand_ps(old, lanes as u16, from));
                }
            }
            if self.queue.parking.lanes != 0 {
                self.move_stacks(group, lanes);
            }
            group.stepping |= lanes;
            free &= !lanes;
            self.from += lanes.count_ones() as usize;
        }
    }

    /// Fills the stacks of lanes that were given the next rays.
    #[inline(always)]
    fn move_stacks(&self, group: &mut Group, lanes: u32) {
        let parking = &self.queue.parking;
        for (i, lane) in lanes_of(lanes).enumerate() {
            let place = self.queue.place[self.from + i] as usize % LANES;
            // The first entry is the bottom.
            for row in 1..group.flights.top[lane] as usize {
                let (node, [near, far]) = parking.later[row][place];
                group.stack[row % ROWS][lane] = Entry { node, near, far, _pad: 0 };
            }
        }
    }

    /// Makes the next sixteen rays ready, traces the packets that they make, and keeps the others
    /// that may meet the tree.
    ///
    /// # Safety
    /// As [`trace`](super::trace).
    #[inline(always)]
    unsafe fn prepare<const ANY: bool>(
        &mut self,
        tree: &KdTree,
        sixteen: Sixteen,
        count: usize,
        done: &mut impl FnMut(usize, &Best),
    ) {
        let Queue { flights, place, prepared, parking } = self.queue;
        let rays = self.left.rays;
        // SAFETY: the caller's.
        unsafe { prepared.take::<Choices>(rays, sixteen, count, &tree.bounds) };
        parking.lanes = 0;
        let mut left = prepared.entering();
        if let Some(stack) = self.packets.as_deref_mut().filter(|stack| stack.is_good::<__m512>()) {
            let place = Some(&mut *parking);
            // SAFETY: the caller's.
            left = unsafe {
                packet::trace::<__m512, Avx512, ANY>(tree, rays, prepared, left, stack, place, done)
            };
        }
        let parked = parking.lanes as u16;
        left |= parking.lanes;
        (self.from, self.len) = (0, left.count_ones() as usize);
        if left == 0 {
            return;
        }
        // SAFETY: rows hold sixteen lanes, those of the queue more.
        unsafe {
            let rows = (&raw const *prepared).cast::<f32>();
            let queue = (&raw mut *flights).cast::<f32>();
            let kept = left as u16;
            for row in 0..Prepared::<LANES>::ROWS {
                let from = _mm512_load_ps(rows.add(row * LANES));
                _mm512_store_ps(queue.add(row * 2 * LANES), _mm512_maskz_compress_ps(kept, from));
            }
            let numbers = _mm512_maskz_compress_epi32(kept, lane_numbers());
            _mm512_storeu_si512(place.as_mut_ptr().cast(), numbers);
            let sets = [kept, parked];
            let rays = &mut flights.rays;
            let [t, u, v, ids] = &parking.best;
            queue_row(&mut rays.near, get_ps(&prepared.near), &parking.span[0], sets);
            queue_row(&mut rays.far, get_ps(&prepared.far), &parking.span[1], sets);
            queue_row(&mut rays.t, get_ps(&prepared.t), t, sets);
            queue_row(&mut flights.hit[0], _mm512_setzero_ps(), u, sets);
            queue_row(&mut flights.hit[1], _mm512_setzero_ps(), v, sets);
            queue_bits(&mut flights.primitive, NO_HIT, as_bits(ids), sets);
            queue_bits(&mut flights.node, Node::ROOT as u32, &parking.node, sets);
            queue_bits(&mut flights.top, 1, &parking.top, sets);
        }
    }
}

/// Puts a row into the queue: what is kept of one, with that of parked rays in its place.
#[inline(always)]
unsafe fn queue_row(
    to: &mut [f32; 2 * LANES],
    row: __m512,
    of_parked: &[f32; LANES],
    [kept, parked]: [u16; 2],
) {
    // SAFETY: the caller's.
    unsafe {
        let row = _mm512_mask_mov_ps(row, parked, get_ps(of_parked));
        _mm512_storeu_ps(to.as_mut_ptr(), _mm512_maskz_compress_ps(kept, row));
    }
}

#[inline(always)]
unsafe fn queue_bits(
    to: &mut [u32; 2 * LANES],
    value: u32,
    of_parked: &[u32; LANES],
    [kept, parked]: [u16; 2],
) {
    // SAFETY: the caller's.
    unsafe {
        let row = _mm512_set1_epi32(value as i32);
        let row = _mm512_mask_mov_epi32(row, parked, get(of_parked));
        _mm512_storeu_si512(to.as_mut_ptr().cast(), _mm512_maskz_compress_epi32(kept, row));
    }
}

/// The lowest `count` bits of a set.
#[inline(always)]
unsafe fn lowest(set: u32, count: u32) -> u32 {
    // SAFETY: the caller's.
    unsafe { _pdep_u32((1 << count.min(31)) - 1, set) }
}
