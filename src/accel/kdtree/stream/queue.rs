//! Rays that wait to go into flight.

use super::{Entry, Flights, Group, ROWS, Vector};
use crate::accel::LANES;
use crate::accel::kdtree::leaf::Best;
use crate::accel::kdtree::node::Node;
use crate::accel::kdtree::packet::{self, Parking};
use crate::accel::kdtree::ray::Prepared;
use crate::accel::kdtree::{KdTree, Left, NO_HIT};
use crate::accel::order::Sixteen;
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

#[cfg(test)]
impl Queue {
    /// Whether rays that left packets ever were in it.
    pub(super) fn has_parked(&self) -> bool {
        self.parking.top.iter().any(|&top| top > 0)
    }
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
    pub(super) unsafe fn refill<V: Vector<N>, const N: usize, const ANY: bool>(
        &mut self,
        tree: &KdTree,
        group: &mut Group<N>,
        mut free: u32,
        done: &mut impl FnMut(usize, &Best),
    ) {
        while free != 0 {
            if self.from == self.len {
                let Some((sixteen, count)) = self.left.take() else { return };
                // SAFETY: the caller's.
                unsafe { self.prepare::<V, N, ANY>(tree, sixteen, count, done) };
                continue;
            }
            // Rows of both have the same numbers.
            const {
                assert!(Flights::<N>::ROWS == Flights::<{ 2 * LANES }>::ROWS);
                assert!(Flights::<N>::NODE_ROW == Flights::<{ 2 * LANES }>::NODE_ROW);
            }
            // The lowest free lanes, as many as there are rays.
            let count = (self.len - self.from) as u32;
            // SAFETY: rows of the queue are readable for a register from `from` on, those of the
            // group hold one.
            let lanes = unsafe {
                let lanes = V::lowest(free, count);
                let to = (&raw mut group.flights).cast::<f32>();
                let queue = (&raw const self.queue.flights).cast::<f32>();
                for row in 0..Flights::<N>::ROWS {
                    let to = to.add(row * N);
                    let from = V::load(queue.add(row * 2 * LANES + self.from));
                    V::load(to).expand(lanes, from).store(to);
                }
                lanes
            };
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
    fn move_stacks<const N: usize>(&self, group: &mut Group<N>, lanes: u32) {
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
    unsafe fn prepare<V: Vector<N>, const N: usize, const ANY: bool>(
        &mut self,
        tree: &KdTree,
        sixteen: Sixteen,
        count: usize,
        done: &mut impl FnMut(usize, &Best),
    ) {
        let Queue { flights, place, prepared, parking } = self.queue;
        let rays = self.left.rays;
        // SAFETY: the caller's.
        unsafe { prepared.take::<V::Choosing>(rays, sixteen, count, &tree.bounds) };
        parking.lanes = 0;
        let mut left = prepared.entering();
        if let Some(stack) = self.packets.as_deref_mut().filter(|stack| stack.is_good::<V>()) {
            let place = Some(&mut *parking);
            // SAFETY: the caller's.
            left = unsafe {
                packet::trace::<V, V::Kernel, ANY>(tree, rays, prepared, left, stack, place, done)
            };
        }
        left |= parking.lanes;
        (self.from, self.len) = (0, left.count_ones() as usize);
        if left == 0 {
            return;
        }
        // SAFETY: rows hold sixteen lanes, those of the queue a register more.
        unsafe {
            if parking.lanes == 0 {
                flights.start_at_root();
            } else {
                complete(parking, prepared);
                for (i, lane) in lanes_of(left).enumerate() {
                    place[i] = lane as u32;
                }
                pack::<V, N>(left, parking.node.as_ptr(), &mut flights.node);
                pack::<V, N>(left, parking.top.as_ptr(), &mut flights.top);
                pack::<V, N>(left, parking.best[1].as_ptr().cast(), as_bits(&mut flights.hit[0]));
                pack::<V, N>(left, parking.best[2].as_ptr().cast(), as_bits(&mut flights.hit[1]));
                pack::<V, N>(left, parking.best[3].as_ptr().cast(), &mut flights.primitive);
            }
            let rows = (&raw const *prepared).cast::<u32>();
            let queue = (&raw mut flights.rays).cast::<[u32; 2 * LANES]>();
            for row in 0..Prepared::<LANES>::ROWS {
                pack::<V, N>(left, rows.add(row * LANES), &mut *queue.add(row));
            }
        }
    }
}

/// Puts what rays have that left packets to the other rays, and the other way round.
fn complete(parking: &mut Parking, prepared: &mut Prepared<LANES>) {
    for lane in 0..LANES {
        if parking.lanes >> lane & 1 == 1 {
            prepared.near[lane] = parking.span[0][lane];
            prepared.far[lane] = parking.span[1][lane];
            prepared.t[lane] = parking.best[0][lane];
        } else {
            parking.node[lane] = Node::ROOT as u32;
            parking.top[lane] = 1;
            (parking.best[1][lane], parking.best[2][lane]) = (0.0, 0.0);
            parking.best[3][lane] = f32::from_bits(NO_HIT);
        }
    }
}

/// Puts the lanes of a set of sixteen into a row, one behind the other.
///
/// # Safety
/// The CPU has the instructions of `V`; there are sixteen words.
#[inline(always)]
unsafe fn pack<V: Vector<N>, const N: usize>(
    set: u32,
    from: *const u32,
    row: &mut [u32; 2 * LANES],
) {
    let mut to = row.as_mut_ptr().cast::<f32>();
    for base in (0..LANES).step_by(N) {
        let part = set >> base & Group::<N>::ALL;
        // SAFETY: sixteen lanes and a register more have room.
        unsafe {
            V::load(from.add(base).cast()).compress(part).store(to);
            to = to.add(part.count_ones() as usize);
        }
    }
}

/// The bits of a row of numbers.
#[inline(always)]
fn as_bits<const N: usize>(row: &mut [f32; N]) -> &mut [u32; N] {
    // SAFETY: any bits are a number, of the same size and alignment.
    unsafe { &mut *(&raw mut *row).cast() }
}
