//! Packets: rays that go the same way, one to a lane, share their way down the tree.
//!
//! The directions of a packet's rays share their signs and their largest axis. A node is tested
//! once for all rays, by intervals that hold every origin and every direction. The children that
//! pass are tested lane by lane when their turn comes; the stack holds the remaining children of
//! nodes. If few lanes enter a child, they leave the packet with their part of the stack, and
//! become rays of the stream.
//!
//! Source of the interval test: Boulos, Wald, Shirley, *Geometric and Arithmetic Culling Methods
//! for Entire Ray Packets*, 2006; here it is made conservative by the widening of boxes and rays
//! that the steps rely on too.

use super::flights::{Flights, Memory};
use super::hierarchy::Bvh;
use super::layout::{Child, FIRST_CHANGE, Node, WIDTH, id_at, triangle_at};
use super::query::Query;
use super::ray::{Prepared, Ray};
use super::steps::{Portable, Steps};
use crate::primitives::triangle::lanes::Tested;
use crate::primitives::triangle::{ShearedRay, Triangle};
use crate::rays::{LANES, Rays};
use crate::simd::{Lanes, SetLanes, lanes_of, load3};

/// Rays leave the packet if no more lanes than this enter a child.
const FEW: u32 = 2;

/// Least number of rays that make a packet.
const ENOUGH: u32 = 4;

/// Number of rays of a packet that must enter a child on average for packets to be faster than a
/// stream, in a hierarchy of `memory` bytes. A stream hides the latency of memory and a packet
/// waits for it: the farther away the nodes, the fuller a packet must be.
pub(super) fn worthwhile(memory: usize) -> u32 {
    const MIB: usize = 1 << 20;
    if memory <= 48 * MIB {
        4
    } else if memory <= 96 * MIB {
        5
    } else {
        9
    }
}

/// Working memory of [`trace`].
#[derive(Debug, Default)]
pub(super) struct Stack {
    rests: Vec<Rest>,
}

/// Children of a node that remain to be visited.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Rest {
    pub(super) node: u32,
    /// Bit `s` for the child that lies `s`-th from the near end.
    pub(super) set: u32,
}

impl Stack {
    pub(super) fn prepare(&mut self, size: usize) {
        if self.rests.len() < size {
            self.rests.resize(size, Rest::default());
        }
    }
}

/// What an instruction set does with rays that go the same way: by default it traces each by
/// itself.
pub(super) trait Packets: Steps {
    /// Traces the packets among sixteen rays, and returns the other rays.
    ///
    /// # Safety
    /// As [`stream::trace`](super::stream::trace).
    #[inline(always)]
    unsafe fn packets<Q: Query>(
        _around: &mut Surroundings,
        _prepared: &Prepared,
        pending: u32,
        _query: &mut Q,
    ) -> u32 {
        pending
    }
}

/// Plain Rust makes no packets.
impl<const MOVES: bool> Packets for Portable<MOVES> {}

/// The steps of packets for one instruction set.
pub(super) trait PacketSteps: Steps {
    /// One lane for each ray of a packet.
    type Lanes: SetLanes;

    /// The children that some ray of the packet may enter before `t_max`: bit `s` for the one that
    /// lies `s`-th from the near end.
    ///
    /// # Safety
    /// The CPU has the instruction set; there is such a node.
    unsafe fn may_enter(node: *const Node, beam: &Beam) -> u32;

    /// [`walk`], as a function of its own, so that its loop and those of the stream do not compete
    /// for registers.
    ///
    /// # Safety
    /// As [`walk`].
    unsafe fn walk<Q: Query>(
        around: &mut Surroundings,
        prepared: &Prepared,
        base: usize,
        set: u32,
        query: &mut Q,
    );
}

/// Bounds of all rays of a packet. The distance at which a ray crosses a plane that it enters
/// through is at least `plane * least - near`, or below 0; for a plane that it leaves through it is
/// at most `plane * most - far`, or both are below 0.
#[derive(Debug)]
pub(super) struct Beam {
    /// The inverse directions of least and of largest size, by axis.
    pub(super) least: [f32; 3],
    pub(super) most: [f32; 3],
    pub(super) near: [f32; 3],
    pub(super) far: [f32; 3],
    /// Farthest end of a ray.
    pub(super) t_max: f32,
    pub(super) order_shift: u32,
    pub(super) entries: [u32; 3],
    /// The first and the last time, if boxes move.
    pub(super) times: [f32; 2],
}

impl Beam {
    /// Bounds of no ray.
    pub(super) const NONE: Self = Self {
        least: [0.0; 3],
        most: [0.0; 3],
        near: [0.0; 3],
        far: [0.0; 3],
        t_max: -1.0,
        order_shift: 0,
        entries: [0; 3],
        times: [0.0; 2],
    };

    /// Bounds of the rays of a set, whose first lane is lane `base` of the prepared rays.
    ///
    /// # Safety
    /// The CPU has the instruction set; `base` leaves enough lanes.
    #[inline(always)]
    pub(super) unsafe fn new<S: PacketSteps>(rays: &Prepared, base: usize, set: u32) -> Self {
        let octant = rays.octant[base + set.trailing_zeros() as usize];
        // SAFETY: the caller's.
        unsafe {
            let [x, y, z] = of_set::<S::Lanes>(&rays.leaving, base, set);
            let leaving = S::Lanes::leasts([x, y, z, x]);
            let [x, y, z] = of_set::<S::Lanes>(&rays.size, base, set);
            let least = S::Lanes::leasts([x, y, z, x]);
            let [x, y, z] = negated_of_set::<S::Lanes>(&rays.size, base, set);
            let most = S::Lanes::leasts([x, y, z, x]);
            let [x, y, z] = negated_of_set::<S::Lanes>(&rays.entering, base, set);
            let t_max =
                S::Lanes::load(rays.t_max.as_ptr().add(base)).replace(!set, S::Lanes::splat(0.0));
            let entering = S::Lanes::leasts([x, y, z, S::Lanes::splat(0.0).sub(t_max)]);
            let mut beam = Self {
                least: [0.0; 3],
                most: [0.0; 3],
                near: [0.0; 3],
                far: [0.0; 3],
                t_max: -entering[3],
                order_shift: 4 * octant,
                entries: Ray::entries(octant),
                times: [0.0; 2],
            };
            if S::MOVES {
                let time = S::Lanes::load(rays.time.as_ptr().add(base));
                let first = time.replace(!set, S::Lanes::splat(1.0));
                let last = S::Lanes::splat(0.0).sub(time.replace(!set, S::Lanes::splat(0.0)));
                let [first, last, ..] = S::Lanes::leasts([first, last, first, last]);
                beam.times = [first, -last];
            }
            for axis in 0..3 {
                let sign = if octant >> axis & 1 == 0 { 1.0 } else { -1.0 };
                beam.least[axis] = least[axis] * sign;
                beam.most[axis] = -most[axis] * sign;
                beam.near[axis] = -entering[axis] * least[axis];
                beam.far[axis] = leaving[axis] * -most[axis];
            }
            beam
        }
    }
}

/// A prepared ray and a triangle of a block. Only doubtful hits need them, so this stays out of
/// loops.
///
/// # Safety
/// There is such a block.
#[cold]
#[inline(never)]
unsafe fn pair_at<S: Steps>(
    (prepared, lane): (&Prepared, usize),
    (block, count, triangle): (*const f32, usize, usize),
) -> (ShearedRay, Triangle) {
    // SAFETY: the caller's.
    let triangle =
        unsafe { triangle_at(block, count, triangle, S::MOVES.then_some(prepared.time[lane])) };
    (Ray::new(prepared, lane).sheared(), triangle)
}

/// Three rows from lane `base` on, infinite outside of a set.
///
/// # Safety
/// The CPU has the instructions of `L`; `base` leaves enough lanes.
#[inline(always)]
unsafe fn of_set<L: Lanes>(rows: &[[f32; LANES]; 3], base: usize, set: u32) -> [L; 3] {
    // SAFETY: the caller's.
    unsafe {
        let ([x, y, z], other) = (load3::<L>(rows, base), L::splat(f32::INFINITY));
        [x.replace(!set, other), y.replace(!set, other), z.replace(!set, other)]
    }
}

/// Three rows from lane `base` on, their signs turned, infinite outside of a set.
///
/// # Safety
/// The CPU has the instructions of `L`; `base` leaves enough lanes.
#[inline(always)]
unsafe fn negated_of_set<L: Lanes>(rows: &[[f32; LANES]; 3], base: usize, set: u32) -> [L; 3] {
    // SAFETY: the caller's.
    unsafe {
        let ([x, y, z], other) = (load3::<L>(rows, base), L::splat(f32::NEG_INFINITY));
        let zero = L::splat(0.0);
        [
            zero.sub(x.replace(!set, other)),
            zero.sub(y.replace(!set, other)),
            zero.sub(z.replace(!set, other)),
        ]
    }
}

/// # Safety
/// The CPU has the instructions of `L`.
#[inline(always)]
unsafe fn negated<L: Lanes>([x, y, z]: [L; 3]) -> [L; 3] {
    // SAFETY: the caller's.
    unsafe {
        let zero = L::splat(0.0);
        [zero.sub(x), zero.sub(y), zero.sub(z)]
    }
}

/// What packets share with the stream.
pub(super) struct Surroundings<'a> {
    pub(super) bvh: &'a Bvh,
    pub(super) rays: &'a Rays,
    /// Times of the rays, if triangles move.
    pub(super) times: &'a [f32],
    pub(super) memory: Memory,
    pub(super) stack: &'a mut Stack,
    pub(super) flights: Flights<'a>,
    pub(super) rays_per_child: RaysPerChild,
}

/// Counts the rays that entered the children that packets came to, so far in this batch; children
/// that none entered count only if boxes move.
#[derive(Clone, Copy, Debug)]
pub(super) struct RaysPerChild {
    children: u32,
    rays: u32,
    worthwhile: u32,
}

impl RaysPerChild {
    /// No counts yet, in a hierarchy of `memory` bytes.
    pub(super) fn new(memory: usize) -> Self {
        Self { children: 0, rays: 0, worthwhile: worthwhile(memory) }
    }

    #[inline(always)]
    fn count(&mut self, lanes: u32) {
        self.children += 1;
        self.rays += lanes.count_ones();
    }

    /// Whether packets pay: rays that share packets with few others are faster in a stream.
    pub(super) fn is_good(self) -> bool {
        self.rays >= self.worthwhile * self.children
    }
}

/// Traces the packets among sixteen rays; returns the rays that are in none.
///
/// # Safety
/// The CPU has the instruction set of `S`; there is room for a stack of this hierarchy.
#[inline(always)]
pub(super) unsafe fn trace<S: PacketSteps, Q: Query>(
    around: &mut Surroundings,
    prepared: &Prepared,
    pending: u32,
    query: &mut Q,
) -> u32 {
    let mut left = 0;
    let lanes = S::Lanes::COUNT;
    for base in (0..LANES).step_by(lanes) {
        let set = pending & ((1 << lanes) - 1) << base;
        if set.count_ones() < ENOUGH {
            left |= set;
        } else {
            // SAFETY: the caller's.
            unsafe { S::walk(around, prepared, base, set, query) };
        }
    }
    left
}

/// Traces one packet: a set of the sixteen rays, whose first lane is `base`.
///
/// # Safety
/// As [`trace`]; `base` leaves enough lanes.
#[inline(always)]
pub(super) unsafe fn walk<S: PacketSteps, Q: Query>(
    around: &mut Surroundings,
    prepared: &Prepared,
    base: usize,
    set: u32,
    query: &mut Q,
) {
    // SAFETY: the caller's.
    unsafe { Packet::<S>::new(prepared, base, set).trace(around, query) }
}

/// A packet on its way.
struct Packet<'a, S: PacketSteps> {
    prepared: &'a Prepared,
    /// The packet's first lane in `prepared`.
    base: usize,
    beam: Beam,
    inverse: [S::Lanes; 3],
    minus_near: [S::Lanes; 3],
    minus_far: [S::Lanes; 3],
    origin: [S::Lanes; 3],
    shear: [S::Lanes; 3],
    axes: [usize; 3],
    /// Times of the rays, if boxes and triangles move.
    time: S::Lanes,
    /// Best distances; minus infinity in lanes without a ray, or whose ray is done.
    t: S::Lanes,
    u: S::Lanes,
    v: S::Lanes,
    /// Bits of ids of best hits; 0 before the first.
    ids: S::Lanes,
    /// Lanes that have a hit.
    found: u32,
    /// Lanes with a ray.
    set: u32,
}

impl<'a, S: PacketSteps> Packet<'a, S> {
    #[inline(always)]
    unsafe fn new(prepared: &'a Prepared, base: usize, set: u32) -> Self {
        let z_axis = prepared.z_axis[set.trailing_zeros() as usize] as usize;
        let set = set >> base;
        // SAFETY: the arrays have `LANES` elements, `base` leaves enough for the packet.
        unsafe {
            let nothing = S::Lanes::splat(0.0);
            let t = S::Lanes::load(prepared.t_max.as_ptr().add(base));
            Self {
                beam: Beam::new::<S>(prepared, base, set),
                inverse: load3(&prepared.inverse, base),
                minus_near: negated(load3(&prepared.near, base)),
                minus_far: negated(load3(&prepared.far, base)),
                origin: load3(&prepared.origin, base),
                shear: load3(&prepared.shear, base),
                time: S::Lanes::load(prepared.time.as_ptr().add(base)),
                axes: [(z_axis + 1) % 3, (z_axis + 2) % 3, z_axis],
                t: t.replace(!set, S::Lanes::splat(f32::NEG_INFINITY)),
                u: nothing,
                v: nothing,
                ids: nothing,
                found: 0,
                set,
                prepared,
                base,
            }
        }
    }

    /// # Safety
    /// As [`trace`].
    #[inline(always)]
    unsafe fn trace<Q: Query>(mut self, around: &mut Surroundings, query: &mut Q) {
        // SAFETY: on each level the stack grows by at most `WIDTH - 1`, which the hierarchy's
        // stack size allows for.
        unsafe {
            let rests = around.stack.rests.as_mut_ptr();
            let mut top = 0;
            let mut rest = Rest { node: 0, set: S::may_enter(around.memory.nodes, &self.beam) };
            loop {
                if rest.set == 0 {
                    if top == 0 {
                        break;
                    }
                    top -= 1;
                    rest = *rests.add(top);
                }
                let node = around.memory.nodes.add(rest.node as usize);
                let order = (*node).order[WIDTH - 1 - rest.set.trailing_zeros() as usize % WIDTH];
                let place = (order >> self.beam.order_shift & 7) as usize;
                let child = (*node).children[place];
                rest.set &= rest.set - 1;
                let lanes = self.enter(node, place);
                if lanes == 0 {
                    // A beam whose rays have many times meets many boxes that none of them enters.
                    if S::MOVES {
                        around.rays_per_child.count(0);
                    }
                    continue;
                }
                around.rays_per_child.count(lanes);
                *rests.add(top) = rest;
                top += usize::from(rest.set != 0);
                rest.set = 0;
                if child.is_block() {
                    self.test_leaf::<Q>(around, child, lanes);
                    if Q::ANY && self.found == self.set {
                        break;
                    }
                } else if child.is_leaf() || lanes.count_ones() <= FEW {
                    self.part(around, child, lanes, top);
                } else {
                    rest.node = child.0;
                    let node = around.memory.nodes.add(child.index());
                    rest.set = S::may_enter(node, &self.beam);
                }
            }
            self.finish(query);
        }
    }

    /// The lanes that enter a child.
    ///
    /// # Safety
    /// The CPU has the instruction set; there is such a node.
    #[inline(always)]
    unsafe fn enter(&self, node: *const Node, place: usize) -> u32 {
        // SAFETY: entries and places lie within the node's planes.
        unsafe {
            let number = |node: *const Node, entry: u32| {
                let planes = node.cast::<u8>().add(entry as usize);
                S::Lanes::splat(*planes.cast::<f32>().add(place))
            };
            let plane = |entry: u32| {
                let plane = number(node, entry);
                if S::MOVES { number(node.add(1), entry).mul_add(self.time, plane) } else { plane }
            };
            let [x, y, z] = self.beam.entries;
            let near = plane(x).mul_add(self.inverse[0], self.minus_near[0]);
            let near = near.max(plane(y).mul_add(self.inverse[1], self.minus_near[1]));
            let near = near.max(plane(z).mul_add(self.inverse[2], self.minus_near[2]));
            let near = near.max(S::Lanes::splat(0.0));
            let far = plane(x ^ 32).mul_add(self.inverse[0], self.minus_far[0]);
            let far = far.min(plane(y ^ 32).mul_add(self.inverse[1], self.minus_far[1]));
            let far = far.min(plane(z ^ 32).mul_add(self.inverse[2], self.minus_far[2]));
            near.le(far.min(self.t))
        }
    }

    /// # Safety
    /// The CPU has the instruction set; `child` is a leaf of the hierarchy.
    #[inline(always)]
    unsafe fn test_leaf<Q: Query>(&mut self, around: &Surroundings, child: Child, lanes: u32) {
        let count = child.block_len();
        // SAFETY: the caller's.
        unsafe {
            let block = around.memory.rows.add(child.index() * S::ROWS);
            let [x, y, z] = self.axes;
            let rows = [block.add(x * count), block.add(y * count), block.add(z * count)];
            for k in 0..count {
                let mut corners = [[self.u; 3]; 3];
                for (c, corner) in corners.iter_mut().enumerate() {
                    for (row, x) in rows.iter().zip(corner) {
                        let number = |row_of| S::Lanes::splat(*row.add(row_of * count + k));
                        *x = number(3 * c);
                        if S::MOVES {
                            *x = x.add(number(FIRST_CHANGE + 3 * c).mul(self.time));
                        }
                    }
                }
                let tested = Tested::with_branch(corners, self.origin, self.shear, self.t, lanes);
                if tested.hits == 0 {
                    continue;
                }
                let tested = tested.settle(|lane| {
                    pair_at::<S>((self.prepared, self.base + lane), (block, count, k))
                });
                let nearer = tested.hits & tested.t.lt(self.t);
                if Q::ANY {
                    self.block(nearer);
                } else {
                    let id = id_at(block, count, k);
                    self.keep(&tested, nearer, id);
                    self.beam.t_max = self.farthest();
                }
            }
        }
    }

    /// # Safety
    /// The CPU has the instruction set.
    #[inline(always)]
    unsafe fn block(&mut self, lanes: u32) {
        self.found |= lanes;
        // SAFETY: the caller's.
        unsafe { self.t = self.t.replace(lanes, S::Lanes::splat(f32::NEG_INFINITY)) };
    }

    /// Keeps hits that are nearer than the best, or as near and of lower id.
    ///
    /// # Safety
    /// The CPU has the instruction set.
    #[inline(always)]
    unsafe fn keep(&mut self, tested: &Tested<S::Lanes>, nearer: u32, id: u32) {
        // SAFETY: the caller's.
        unsafe {
            let mut better = nearer;
            let equal = tested.hits & !nearer;
            if equal != 0 {
                let ids = bits_of(self.ids);
                for lane in lanes_of(equal) {
                    better |= u32::from(id < ids[lane]) << lane;
                }
            }
            let [u, v] = tested.weights();
            self.t = self.t.replace(better, tested.t);
            self.u = self.u.replace(better, u);
            self.v = self.v.replace(better, v);
            self.ids = self.ids.replace(better, S::Lanes::splat(f32::from_bits(id)));
            self.found |= better;
        }
    }

    /// # Safety
    /// The CPU has the instruction set.
    #[inline(always)]
    unsafe fn farthest(&self) -> f32 {
        // SAFETY: the caller's.
        unsafe { self.t.largest() }
    }

    /// Takes lanes out of the packet and puts each into flight, with its part of the stack.
    ///
    /// # Safety
    /// As [`trace`]; the lanes stand before `child`, with `top` entries on the stack.
    #[inline(always)]
    unsafe fn part(&mut self, around: &mut Surroundings, child: Child, lanes: u32, top: usize) {
        let mut state = [[0.0; LANES]; 4];
        // SAFETY: there are as many values as lanes, or more; a ray has no more entries than its
        // packet, and there is a free place for each of sixteen rays.
        unsafe {
            self.t.store(state[0].as_mut_ptr());
            self.u.store(state[1].as_mut_ptr());
            self.v.store(state[2].as_mut_ptr());
            self.ids.store(state[3].as_mut_ptr());
            for lane in lanes_of(lanes) {
                let mut ray = Ray::new(self.prepared, self.base + lane);
                [ray.t, ray.u, ray.v] = [state[0][lane], state[1][lane], state[2][lane]];
                ray.primitive = state[3][lane].to_bits();
                ray.is_hit = self.found >> lane & 1;
                let ray = around.flights.park(ray, child);
                for i in 0..top {
                    let Rest { node, set } = *around.stack.rests.get_unchecked(i);
                    let node = around.memory.nodes.add(node as usize);
                    around.memory.push_children::<S>(node, &mut *ray, (set as u8).reverse_bits());
                }
            }
            self.t = self.t.replace(lanes, S::Lanes::splat(f32::NEG_INFINITY));
        }
        self.set &= !lanes;
    }

    /// # Safety
    /// The CPU has the instruction set.
    #[inline(always)]
    unsafe fn finish<Q: Query>(&self, query: &mut Q) {
        let hits = [self.t, self.u, self.v, self.ids];
        // SAFETY: the indices are those of rays of the batch.
        unsafe { query.accept_lanes(self.prepared, self.base, self.found & self.set, hits) };
    }
}

/// # Safety
/// The CPU has the instructions of `L`.
#[inline(always)]
unsafe fn bits_of<L: Lanes>(lanes: L) -> [u32; LANES] {
    let mut values = [0.0f32; LANES];
    // SAFETY: there are as many values as lanes, or more.
    unsafe { lanes.store(values.as_mut_ptr()) };
    values.map(f32::to_bits)
}
