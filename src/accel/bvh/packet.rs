//! Packets: rays that go the same way, one to a lane, share their way down the tree.
//!
//! A packet's rays have the signs and the largest axis of their directions in common. A node is
//! tested once for all of them, by intervals that hold every origin and every direction; the
//! children that are left are tested lane by lane, and every child keeps on the stack where each
//! lane enters it. Where few lanes are left they leave the packet and go into flight by themselves,
//! with their part of the stack.
//!
//! Source of the interval test: Boulos, Wald, Shirley, *Geometric and Arithmetic Culling Methods
//! for Entire Ray Packets*, 2006; here it is made conservative by the widening of boxes and rays
//! that the steps rely on too.

use super::Bvh;
use super::layout::{Child, Corners, Node, WIDTH, triangle_at};
use super::ray::{Prepared, Ray};
use super::steps::Steps;
use super::stream::{Flights, Memory, Query};
use crate::accel::simd::{Lanes, lanes_of, load3};
use crate::accel::triangle::lanes::Tested;
use crate::accel::{LANES, Rays};

/// With so many lanes or fewer, rays leave the packet.
const FEW: u32 = 2;

/// Rays that go the same way make a packet if there are so many of them.
const ENOUGH: u32 = 4;

/// Packets go on being made while at least one lane in so many is in use on average.
const LANES_PER_USE: u32 = 2;

/// Working memory of [`trace`].
#[derive(Debug, Default)]
pub(super) struct Stack {
    nears: Vec<Nears>,
    children: Vec<Child>,
}

/// Where each lane enters a child; NaN where it does not.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Nears([f32; LANES]);

impl Stack {
    pub(super) fn prepare(&mut self, size: usize) {
        if self.nears.len() < size {
            self.nears.resize(size, Nears([0.0; LANES]));
            self.children.resize(size, Child::DONE);
        }
    }
}

/// The steps of packets for one instruction set.
pub(super) trait PacketSteps: Steps {
    /// One lane for each ray of a packet.
    type Lanes: Lanes;

    /// Writes the places of the children that some ray of the packet may enter before `t_max`, from
    /// far to near; returns how many. Eight may be overwritten.
    ///
    /// # Safety
    /// The CPU has the instruction set.
    unsafe fn may_enter(node: &Node, beam: &Beam, places: &mut [u32; WIDTH]) -> usize;
}

/// What holds all rays of a packet. Axes are turned so that all rays go toward larger coordinates.
#[derive(Debug)]
pub(super) struct Beam {
    /// 1 or -1, by axis: what turns a plane.
    pub(super) signs: [f32; 3],
    /// Largest turned origin, by axis, where rays enter, and least one where they leave.
    pub(super) entering: [f32; 3],
    pub(super) leaving: [f32; 3],
    /// Least and largest size of the inverse direction, by axis.
    pub(super) inverses: [[f32; 2]; 3],
    /// Farthest end of a ray.
    pub(super) t_max: f32,
    pub(super) order_shift: u32,
    pub(super) entries: [u32; 3],
}

impl Beam {
    /// Holds the rays of a set, whose first lane is lane `base` of those made ready.
    ///
    /// # Safety
    /// The CPU has the instructions of `L`; `base` leaves enough lanes.
    #[inline(always)]
    unsafe fn new<L: Lanes>(rays: &Prepared, base: usize, set: u32) -> Self {
        let octant = rays.octant[base + set.trailing_zeros() as usize];
        // SAFETY: the caller's.
        unsafe {
            let of_set = |values: &[f32; LANES], other: f32| {
                L::load(values.as_ptr().add(base)).replace(!set, L::splat(other))
            };
            let mut beam = Self {
                signs: [0.0; 3],
                entering: [0.0; 3],
                leaving: [0.0; 3],
                inverses: [[0.0; 2]; 3],
                t_max: of_set(&rays.t_max, 0.0).largest(),
                order_shift: 4 * octant,
                entries: Ray::entries(octant),
            };
            for axis in 0..3 {
                let sizes = &rays.size[axis];
                beam.signs[axis] = if octant >> axis & 1 == 0 { 1.0 } else { -1.0 };
                beam.entering[axis] = of_set(&rays.entering[axis], f32::NEG_INFINITY).largest();
                beam.leaving[axis] = of_set(&rays.leaving[axis], f32::INFINITY).least();
                let least = of_set(sizes, f32::INFINITY).least();
                beam.inverses[axis] = [least, of_set(sizes, 0.0).largest()];
            }
            beam
        }
    }
}

/// What packets need of their surroundings.
pub(super) struct Surroundings<'a> {
    pub(super) bvh: &'a Bvh,
    pub(super) rays: &'a Rays,
    pub(super) memory: Memory,
    pub(super) stack: &'a mut Stack,
    pub(super) flights: Flights<'a>,
    pub(super) use_of_lanes: UseOfLanes,
}

/// How many of the lanes had something to do, so far in this batch.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct UseOfLanes {
    all: u32,
    used: u32,
}

impl UseOfLanes {
    /// Whether packets are worth their while: rays that are in many packets with few lanes in use
    /// are faster by themselves.
    pub(super) fn is_good(self) -> bool {
        LANES_PER_USE * self.used >= self.all
    }
}

/// Orders the rays of a batch by the way they go, so that packets are full: those that go one way
/// keep their order, which is that of neighbours. The number of rays is made whole by repeating the
/// last one; rays that are in order already get none.
pub(super) fn order_by_way(rays: &Rays, order: &mut Vec<u32>, ways: &mut Vec<u8>) {
    const WAYS: usize = 32;
    let n = rays.len();
    ways.clear();
    let [x, y, z] = &rays.direction;
    ways.extend(x[..n].iter().zip(&y[..n]).zip(&z[..n]).map(|((&x, &y), &z)| way(x, y, z)));
    order.clear();
    if ways.is_sorted() {
        return;
    }
    let mut places = [0u32; WAYS];
    for &way in &*ways {
        places[usize::from(way)] += 1;
    }
    let mut place = 0;
    for count in &mut places {
        place += std::mem::replace(count, place);
    }
    order.resize(n.next_multiple_of(LANES), n.saturating_sub(1) as u32);
    for (i, &way) in ways.iter().enumerate() {
        let place = &mut places[usize::from(way)];
        order[*place as usize] = i as u32;
        *place += 1;
    }
}

/// Signs of a direction and its largest axis; nothing depends on how equals are told apart.
#[inline(always)]
fn way(x: f32, y: f32, z: f32) -> u8 {
    let negative = |v: f32| (v.to_bits() >> 31) as u8;
    let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
    let largest = if ax >= ay && ax >= az { 0 } else { 1 + u8::from(ay < az) };
    negative(x) | negative(y) << 1 | negative(z) << 2 | largest << 3
}

/// Traces the packets that sixteen rays make; returns the rays that are left, which go other ways
/// than most.
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
    let mut ways = prepared.octant;
    for (way, z_axis) in ways.iter_mut().zip(&prepared.z_axis) {
        *way = *way << 2 | z_axis;
    }
    let mut left = 0;
    let lanes = S::Lanes::COUNT;
    for base in (0..LANES).step_by(lanes) {
        let mut part = pending & ((1 << lanes) - 1) << base;
        while part != 0 {
            let way = ways[part.trailing_zeros() as usize];
            let mut alike = 0;
            for (lane, &other) in ways.iter().enumerate() {
                alike |= u32::from(other == way) << lane;
            }
            let set = part & alike;
            part &= !set;
            if set.count_ones() < ENOUGH {
                left |= set;
                continue;
            }
            // SAFETY: the caller's.
            unsafe { Packet::<S>::new(prepared, base, set).trace(around, query) };
        }
    }
    left
}

/// A packet under way.
struct Packet<'a, S: PacketSteps> {
    prepared: &'a Prepared,
    /// The first lane of `prepared` that is one of the packet.
    base: usize,
    beam: Beam,
    inverse: [S::Lanes; 3],
    near: [S::Lanes; 3],
    far: [S::Lanes; 3],
    origin: [S::Lanes; 3],
    shear: [S::Lanes; 3],
    axes: [usize; 3],
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
                beam: Beam::new::<S::Lanes>(prepared, base, set),
                inverse: load3(&prepared.inverse, base),
                near: load3(&prepared.near, base),
                far: load3(&prepared.far, base),
                origin: load3(&prepared.origin, base),
                shear: load3(&prepared.shear, base),
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
            let nears = around.stack.nears.as_mut_ptr();
            let children = around.stack.children.as_mut_ptr();
            *nears = Nears([0.0; LANES]);
            *children = Child::node(0);
            let mut top = 1;
            while top > 0 {
                top -= 1;
                let lanes = S::Lanes::load((*nears.add(top)).0.as_ptr()).le(self.t);
                if lanes == 0 {
                    continue;
                }
                around.use_of_lanes.all += S::Lanes::COUNT as u32;
                around.use_of_lanes.used += lanes.count_ones();
                let child = *children.add(top);
                if child.is_block() {
                    self.test_leaf::<Q>(around, child, lanes);
                    if Q::ANY && self.found == self.set {
                        break;
                    }
                } else if child.is_leaf() || lanes.count_ones() <= FEW {
                    self.part(around, child, lanes, top);
                } else {
                    let node = &*around.memory.nodes.add(child.index());
                    let mut places = [0; WIDTH];
                    let count = S::may_enter(node, &self.beam, &mut places);
                    for &place in &places[..count] {
                        let near = self.enter(node, place as usize);
                        let Some(near) = near else { continue };
                        near.store((*nears.add(top)).0.as_mut_ptr());
                        *children.add(top) = node.children[place as usize & (WIDTH - 1)];
                        top += 1;
                    }
                    around.memory.prefetch(*children.add(top.saturating_sub(1)));
                }
            }
            self.finish(query);
        }
    }

    /// Where the lanes enter a child; NaN in those that do not, `None` if none does.
    ///
    /// # Safety
    /// The CPU has the instruction set.
    #[inline(always)]
    unsafe fn enter(&self, node: &Node, place: usize) -> Option<S::Lanes> {
        // SAFETY: entries and places lie within the node's planes.
        unsafe {
            let planes = node.planes.as_ptr().cast::<u8>();
            let plane =
                |entry: u32| S::Lanes::splat(*planes.add(entry as usize).cast::<f32>().add(place));
            let [x, y, z] = self.beam.entries;
            let near = plane(x).mul_sub(self.inverse[0], self.near[0]);
            let near = near.max(plane(y).mul_sub(self.inverse[1], self.near[1]));
            let near = near.max(plane(z).mul_sub(self.inverse[2], self.near[2]));
            let near = near.max(S::Lanes::splat(0.0));
            let far = plane(x ^ 32).mul_sub(self.inverse[0], self.far[0]);
            let far = far.min(plane(y ^ 32).mul_sub(self.inverse[1], self.far[1]));
            let far = far.min(plane(z ^ 32).mul_sub(self.inverse[2], self.far[2]));
            let lanes = near.le(far.min(self.t));
            (lanes != 0).then_some(near.replace(!lanes, S::Lanes::splat(f32::NAN)))
        }
    }

    /// # Safety
    /// The CPU has the instruction set; `child` is a leaf of the hierarchy.
    #[inline(always)]
    unsafe fn test_leaf<Q: Query>(&mut self, around: &Surroundings, child: Child, lanes: u32) {
        let count = child.block_len();
        // SAFETY: the caller's.
        unsafe {
            let block = around.memory.rows.add(child.index() * Corners::PER_TRIANGLE);
            for k in 0..count {
                let mut corners = [[self.u; 3]; 3];
                for (c, corner) in corners.iter_mut().enumerate() {
                    for (axis, x) in self.axes.iter().zip(corner) {
                        *x = S::Lanes::splat(*block.add((3 * c + axis) * count + k));
                    }
                }
                let tested = Tested::new(corners, self.origin, self.shear, self.t, lanes);
                if tested.hits == 0 {
                    continue;
                }
                let tested = tested.settle(|lane| {
                    let ray = Ray::new(self.prepared, self.base + lane);
                    (ray.sheared(), triangle_at(block, count, k))
                });
                let nearer = tested.hits & tested.t.lt(self.t);
                if Q::ANY {
                    self.block(nearer);
                } else {
                    let id = *around.bvh.ids.get_unchecked(child.index() + k);
                    self.keep(&tested, nearer, id);
                }
            }
            if !Q::ANY {
                self.beam.t_max = self.farthest();
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

    /// Puts some lanes into flight by themselves, each with its part of the stack; they leave the
    /// packet.
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
                ray.is_hit = self.found >> lane & 1 == 1;
                let ray = around.flights.park(ray, child);
                for i in 0..top {
                    let near = around.stack.nears.get_unchecked(i).0[lane];
                    let child = *around.stack.children.get_unchecked(i);
                    // Not NaN, and not behind the best hit.
                    if near <= (*ray).t {
                        around.memory.push(&mut *ray, near, child);
                    }
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
        let mut state = [[0.0; LANES]; 3];
        // SAFETY: there are as many values as lanes, or more.
        let ids = unsafe {
            for (values, lanes) in state.iter_mut().zip([self.t, self.u, self.v]) {
                lanes.store(values.as_mut_ptr());
            }
            bits_of(self.ids)
        };
        for lane in lanes_of(self.found & self.set) {
            let hit = [state[0][lane], state[1][lane], state[2][lane]];
            let index = self.prepared.index[self.base + lane] as usize;
            query.accept(index, hit, ids[lane]);
        }
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
