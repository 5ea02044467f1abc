//! Rays on their way through boxes in packets of neighbours, which share their way. A box is tested
//! for all of them at once.
//!
//! The rays of a packet have directions of the same signs. A node is tested once for all of them, by
//! intervals; the children that pass are tested lane by lane when their turn comes, as in the
//! [packets](crate::structure::bvh::packet) of a hierarchy over triangles.

use super::Boxes;
use crate::isa::{Isa, Lanewise};
use crate::rays::{LANES, Rays};
use crate::simd::{Lanes, lanes_of, load3, prefetch};
use crate::structure::bvh::layout::{Child, Node, WIDTH};
#[cfg(target_arch = "aarch64")]
use crate::structure::bvh::neon;
use crate::structure::bvh::packet::{Beam, PacketSteps, Rest, worthwhile};
use crate::structure::bvh::ray::Prepared;
#[cfg(target_arch = "x86_64")]
use crate::structure::bvh::x86;

/// Packets of rays on their way.
#[derive(Debug, Default)]
pub(crate) struct Packets {
    /// Those of this batch, and working memory of others behind them.
    all: Vec<Packet>,
    len: usize,
    /// Numbers of the packets that stand before a box.
    halted: Vec<u32>,
    /// Rays that are not tame.
    wild: Vec<u32>,
    /// How often a packet has halted, and with how many rays altogether.
    halts: usize,
    rays: usize,
}

/// A packet: as many lanes as the instruction set has.
#[derive(Debug)]
#[repr(align(64))]
struct Packet {
    inverse: [[f32; LANES]; 3],
    near: [[f32; LANES]; 3],
    far: [[f32; LANES]; 3],
    /// End of each ray; negative: it is done, or not in the packet.
    t: [f32; LANES],
    beam: Beam,
    /// Number of the first of the sixteen neighbours to which its rays belong, and the first of them
    /// that is a lane.
    first: u32,
    base: u32,
    /// What the packet stands before, and which of its rays do.
    at: Child,
    set: u32,
    /// What remains to be visited.
    rests: Vec<Rest>,
}

impl Packets {
    /// Whether there are packets on an instruction set.
    pub(crate) fn exist(isa: Isa) -> bool {
        isa != Isa::Portable
    }

    /// Sets out with the `count` rays from `first` on, a multiple of [`LANES`], up to the distances in
    /// `reach`, and goes on until each packet has halted. Rays that are not tame do not set out.
    pub(crate) fn start<T: Copy>(
        &mut self,
        boxes: &Boxes<T>,
        (rays, reach): (&Rays, &[f32]),
        first: usize,
        count: usize,
    ) {
        assert!(reach.len() >= (first + count).next_multiple_of(LANES));
        (self.len, self.halts, self.rays) = (0, 0, 0);
        self.halted.clear();
        self.wild.clear();
        if !boxes.nodes.is_empty() {
            self.run(boxes, Step::Start { rays, reach, first, count });
        }
    }

    /// Goes on with all packets that stand before a box, until each has halted again.
    pub(crate) fn go_on<T: Copy>(&mut self, boxes: &Boxes<T>) {
        self.run(boxes, Step::GoOn);
    }

    /// Numbers of the packets that stand before a box, ascending.
    pub(crate) fn halted(&self) -> &[u32] {
        &self.halted
    }

    /// The box before which a halted packet stands.
    #[inline]
    pub(crate) fn leaf(&self, packet: u32) -> u32 {
        self.all[packet as usize].at.index() as u32
    }

    /// Sixteen neighbours, by the number of the first, and which of them stand before the box.
    #[inline]
    pub(crate) fn rays(&self, packet: u32) -> (usize, u32) {
        let packet = &self.all[packet as usize];
        (packet.first as usize, packet.set << packet.base)
    }

    /// Numbers of the rays that did not set out, counted from the first; [`Boxes::visit`] is for
    /// them.
    pub(crate) fn wild(&self) -> &[u32] {
        &self.wild
    }

    /// Makes a ray of a halted packet shorter; a negative end ends its way.
    #[inline]
    pub(crate) fn shorten(&mut self, packet: u32, neighbour: usize, t: f32) {
        let packet = &mut self.all[packet as usize];
        packet.t[neighbour - packet.base as usize] = t;
    }

    /// Whether so many rays stood before a box together, on average, that packets were faster than
    /// single rays.
    pub(crate) fn were_worthwhile<T: Copy + Send + Sync>(&self, boxes: &Boxes<T>) -> bool {
        self.rays >= worthwhile(boxes.memory()) as usize * self.halts
    }

    fn run<T: Copy>(&mut self, boxes: &Boxes<T>, step: Step) {
        match boxes.isa {
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512 => {
                boxes.isa.run(Going::<T, x86::Avx512<false, false>>::new(self, boxes, step));
            }
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 => {
                boxes.isa.run(Going::<T, x86::Avx2<false, false>>::new(self, boxes, step));
            }
            #[cfg(target_arch = "aarch64")]
            Isa::Neon => {
                boxes.isa.run(Going::<T, neon::Neon<false, false>>::new(self, boxes, step));
            }
            _ => unreachable!("packets exist"),
        }
    }
}

#[derive(Clone, Copy)]
enum Step<'a> {
    Start { rays: &'a Rays, reach: &'a [f32], first: usize, count: usize },
    GoOn,
}

/// Work of [`Packets`] for one instruction set.
struct Going<'a, T, S> {
    packets: &'a mut Packets,
    boxes: &'a Boxes<T>,
    step: Step<'a>,
    set: std::marker::PhantomData<S>,
}

impl<'a, T: Copy, S: PacketSteps> Going<'a, T, S> {
    fn new(packets: &'a mut Packets, boxes: &'a Boxes<T>, step: Step<'a>) -> Self {
        Self { packets, boxes, step, set: std::marker::PhantomData }
    }

    /// Makes packets of neighbours.
    ///
    /// # Safety
    /// The CPU has the instruction set of `S`.
    #[inline(always)]
    unsafe fn start(&mut self, rays: &Rays, reach: &[f32], first: usize, count: usize) {
        let Packets { all, len, wild, .. } = &mut *self.packets;
        let mut prepared = Prepared::EMPTY;
        for chunk in (0..count).step_by(LANES) {
            prepared.fill_widened(rays, reach, first + chunk, self.boxes.error);
            let (mut has_length, mut tame) = (0u32, 0u32);
            for lane in 0..LANES {
                has_length |= u32::from(prepared.t_max[lane] > 0.0) << lane;
                tame |= prepared.is_tame[lane] << lane;
            }
            has_length &= u32::MAX >> (32 - (count - chunk).min(LANES));
            tame = if self.boxes.is_tame { has_length & tame } else { 0 };
            wild.extend(lanes_of(has_length & !tame).map(|lane| (chunk + lane) as u32));
            let lanes = S::Lanes::COUNT;
            for base in (0..LANES).step_by(lanes) {
                let mut pending = tame & ((1 << lanes) - 1) << base;
                while pending != 0 {
                    let octant = prepared.octant[pending.trailing_zeros() as usize];
                    let alike = |lane: &usize| prepared.octant[*lane] == octant;
                    let set = lanes_of(pending).filter(alike).fold(0, |set, lane| set | 1 << lane);
                    pending &= !set;
                    if all.len() == *len {
                        all.push(Packet::NONE);
                    }
                    // SAFETY: the caller's; there is a root, and `base` leaves enough lanes.
                    unsafe {
                        all[*len].set_out::<S>(self.boxes.nodes.as_ptr(), &prepared, base, set);
                    }
                    (all[*len].first, all[*len].base) = ((first + chunk) as u32, base as u32);
                    *len += 1;
                }
            }
        }
    }

    /// Moves a packet on until it has halted. Returns whether it has.
    ///
    /// # Safety
    /// As [`start`](Self::start); the packet has set out.
    #[inline(always)]
    unsafe fn walk(boxes: &Boxes<T>, packet: &mut Packet) -> bool {
        let nodes = boxes.nodes.as_ptr();
        // SAFETY: the caller's; nodes that children name exist.
        unsafe {
            packet.beam.t_max = packet.longest::<S::Lanes>();
            if packet.beam.t_max < 0.0 {
                return false;
            }
            let inverse = load3::<S::Lanes>(&packet.inverse, 0);
            let near = load3::<S::Lanes>(&packet.near, 0);
            let far = load3::<S::Lanes>(&packet.far, 0);
            let t = S::Lanes::load(packet.t.as_ptr());
            while let Some(mut rest) = packet.rests.pop() {
                let node = &*nodes.add(rest.node as usize);
                while rest.set != 0 {
                    let nearest = rest.set.trailing_zeros() as usize;
                    rest.set &= rest.set - 1;
                    let word = node.order[WIDTH - 1 - nearest];
                    let place = (word >> packet.beam.order_shift & 7) as usize;
                    let entered = enter(node, place, &packet.beam.entries, (inverse, near, far, t));
                    if entered == 0 {
                        continue;
                    }
                    let child = node.children[place];
                    if rest.set != 0 {
                        packet.rests.push(rest);
                    }
                    if child.is_leaf() {
                        (packet.at, packet.set) = (child, entered);
                        let content = boxes.contents.as_ptr().wrapping_add(child.index());
                        prefetch::<false>(content.cast());
                        return true;
                    }
                    let below = nodes.add(child.index());
                    let set = S::may_enter(below, &packet.beam);
                    packet.rests.push(Rest { node: child.index() as u32, set });
                    break;
                }
            }
        }
        false
    }
}

/// The lanes that enter the box of a child before their ends.
///
/// # Safety
/// The CPU has the instructions of `L`; there is such a child, and `entries` are offsets of planes.
#[inline(always)]
unsafe fn enter<L: Lanes>(
    node: &Node,
    place: usize,
    entries: &[u32; 3],
    (inverse, near, far, t): ([L; 3], [L; 3], [L; 3], L),
) -> u32 {
    // SAFETY: the caller's.
    unsafe {
        let (mut begin, mut end) = (L::splat(0.0), t);
        for axis in 0..3 {
            let negative = (entries[axis] >> 5 & 1) as usize;
            let entry = L::splat(node.planes[2 * axis + negative][place]);
            let exit = L::splat(node.planes[2 * axis + 1 - negative][place]);
            begin = begin.max(entry.mul_sub(inverse[axis], near[axis]));
            end = end.min(exit.mul_sub(inverse[axis], far[axis]));
        }
        begin.le(end)
    }
}

impl Packet {
    const NONE: Self = Self {
        inverse: [[0.0; LANES]; 3],
        near: [[0.0; LANES]; 3],
        far: [[0.0; LANES]; 3],
        t: [-1.0; LANES],
        beam: Beam::NONE,
        first: 0,
        base: 0,
        at: Child::DONE,
        set: 0,
        rests: Vec::new(),
    };

    /// Becomes the packet of a set of prepared rays, whose first lane is `base`, before a root.
    ///
    /// # Safety
    /// The CPU has the instruction set; there is such a node; `base` leaves enough lanes.
    #[inline(always)]
    unsafe fn set_out<S: PacketSteps>(
        &mut self,
        root: *const Node,
        rays: &Prepared,
        base: usize,
        set: u32,
    ) {
        // Beams count the lanes of a set from `base` on.
        let of_packet = set >> base;
        // SAFETY: the caller's; rows have as many lanes as the widest set.
        unsafe {
            for axis in 0..3 {
                let lanes = |rows: &[[f32; LANES]; 3]| rows[axis].as_ptr().wrapping_add(base);
                S::Lanes::load(lanes(&rays.inverse)).store(self.inverse[axis].as_mut_ptr());
                S::Lanes::load(lanes(&rays.near)).store(self.near[axis].as_mut_ptr());
                S::Lanes::load(lanes(&rays.far)).store(self.far[axis].as_mut_ptr());
            }
            let t = S::Lanes::load(rays.t_max.as_ptr().wrapping_add(base));
            t.replace(!of_packet, S::Lanes::splat(-1.0)).store(self.t.as_mut_ptr());
            self.beam = Beam::new::<S>(rays, base, of_packet);
            self.rests.clear();
            self.rests.push(Rest { node: 0, set: S::may_enter(root, &self.beam) });
        }
    }

    /// Where the longest ray ends; negative if all are done.
    ///
    /// # Safety
    /// The CPU has the instructions of `L`.
    #[inline(always)]
    unsafe fn longest<L: Lanes>(&self) -> f32 {
        // SAFETY: the caller's; there are as many lanes.
        unsafe { L::load(self.t.as_ptr()).largest() }
    }
}

impl<T: Copy, S: PacketSteps> Lanewise for Going<'_, T, S> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        // SAFETY: the work is run on the instruction set of `S`, by packets that have set out.
        unsafe {
            if let Step::Start { rays, reach, first, count } = self.step {
                self.start(rays, reach, first, count);
                self.packets.halted.extend(0..self.packets.len as u32);
            }
            let Packets { all, halted, halts, rays, .. } = self.packets;
            // A loop, not a closure, which would be compiled without the instruction set.
            let mut kept = 0;
            for i in 0..halted.len() {
                let number = halted[i];
                let packet = &mut all[number as usize];
                if Self::walk(self.boxes, packet) {
                    halted[kept] = number;
                    kept += 1;
                    *halts += 1;
                    *rays += packet.set.count_ones() as usize;
                }
            }
            halted.truncate(kept);
        }
    }
}
