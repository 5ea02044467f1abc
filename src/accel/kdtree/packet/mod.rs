//! Packets: rays that go the same way, one to a lane, share their way down the tree.
//!
//! A packet's rays have the signs and the largest axis of their directions in common, so that all
//! of them meet the children of a node in the same order. Each lane keeps the part of its ray that
//! lies in the cell. Where few lanes are left, they leave the packet with what is on the stack for
//! them and become rays of the stream, or, where there is none, go through that part of the tree one
//! by one.
//!
//! Before rays and triangles of a leaf are tested one by one, those triangles are left out that lie
//! beside all rays: bounds on origins and shears give bounds on the sheared corners.

#![allow(clippy::needless_range_loop)] // closures around intrinsics would become calls

mod stack;

pub(super) use stack::{Parking, Stack};

use stack::Later;

use super::leaf::{Best, corners_of, triangle_at};
use super::node::{Chunk, Node};
use super::ray::Prepared;
use super::single::{self, Kernel, Visit};
use super::{KdTree, MAX_DEPTH};
use crate::accel::simd::{Lanes, lanes_of, load3};
use crate::accel::triangle::lanes::Tested;
use crate::accel::triangle::turned::{larger, smaller};
use crate::accel::{LANES, Rays};

/// So many lanes or fewer go on by themselves.
const FEW: u32 = 2;

/// Rays that go the same way make a packet if there are so many of them.
const ENOUGH: u32 = 4;

/// Triangles beside all rays are left out of chunks with so many or more.
const CULLED: usize = 3;

/// Corners count as beside the rays if they are farther than this part of the scene: an area whose
/// sign underflow has spoilt is smaller than what this makes of it.
const CLEAR: f32 = 1.0 / (1u32 << 23) as f32;

/// Traces the packets that sixteen rays make; returns the rays that are left, which go other ways
/// than most. Those that leave a packet are put into `parking`, if there is one.
///
/// # Safety
/// The CPU has the instructions of `L` and of `K`.
#[inline(always)]
pub(super) unsafe fn trace<L: Lanes, K: Kernel, const ANY: bool>(
    tree: &KdTree,
    rays: &Rays,
    prepared: &Prepared<LANES>,
    pending: u32,
    stack: &mut Stack,
    mut parking: Option<&mut Parking>,
    done: &mut impl FnMut(usize, &Best),
) -> u32 {
    let mut left = 0;
    for base in (0..LANES).step_by(L::COUNT) {
        let mut part = pending & (((1 << L::COUNT) - 1) << base);
        while part != 0 {
            let lane = part.trailing_zeros() as usize;
            let way = prepared.way[lane];
            let mut alike = 0;
            for lane in 0..LANES {
                let is = prepared.way[lane] == way;
                alike |= u32::from(is) << lane;
            }
            let set = part & alike;
            part &= !set;
            if set.count_ones() < ENOUGH {
                left |= set;
                continue;
            }
            // SAFETY: the caller's.
            unsafe {
                let mut packet = Packet::<L>::new(tree, prepared, base, set >> base);
                packet.walk::<K, ANY>(tree, rays, stack, parking.as_deref_mut());
                packet.finish(done);
            }
        }
    }
    left
}

/// A packet under way.
struct Packet<'a, L> {
    prepared: &'a Prepared<LANES>,
    /// The first lane of `prepared` that is one of the packet.
    base: usize,
    set: u32,
    way: usize,
    axes: [usize; 3],
    inverse: [L; 3],
    early: [L; 3],
    late: [L; 3],
    origin: [L; 3],
    shear: [L; 3],
    /// Best hits, as [`Best`] has them; t is minus infinity where any hit was enough.
    t: L,
    u: L,
    v: L,
    primitive: L,
    bounds: LineBounds,
}

/// Bounds on origins and shears, in sheared axes.
struct LineBounds {
    origin: [[f32; 2]; 3],
    shear: [[f32; 2]; 2],
    /// Sheared corners at least so far from the rays are clear of them.
    clear: f32,
}

impl LineBounds {
    #[inline(always)]
    fn new(tree: &KdTree, prepared: &Prepared<LANES>, set: u32, axes: [usize; 3]) -> Self {
        let origin = [
            extent(&prepared.origin[0], set),
            extent(&prepared.origin[1], set),
            extent(&prepared.origin[2], set),
        ];
        let shear = [extent(&prepared.shear[0], set), extent(&prepared.shear[1], set)];
        let mut reach = 0.0;
        for k in 0..3 {
            let (min, max) = (tree.bounds.min[axes[k]], tree.bounds.max[axes[k]]);
            reach = larger(larger(max - origin[k][0], origin[k][1] - min), reach);
        }
        Self { origin, shear, clear: 2.0 * reach * CLEAR }
    }
}

/// Least and largest of the lanes of a set.
#[inline(always)]
fn extent(values: &[f32; LANES], set: u32) -> [f32; 2] {
    let mut extent = [f32::INFINITY, f32::NEG_INFINITY];
    for (lane, &x) in values.iter().enumerate() {
        let is = set >> lane & 1 == 1;
        extent[0] = smaller(if is { x } else { f32::INFINITY }, extent[0]);
        extent[1] = larger(if is { x } else { f32::NEG_INFINITY }, extent[1]);
    }
    extent
}

/// The best hit of a lane.
#[inline(always)]
fn best_of(hits: &[[f32; LANES]; 4], lane: usize) -> Best {
    let [t, u, v] = [hits[0][lane], hits[1][lane], hits[2][lane]];
    Best { t, u, v, primitive: hits[3][lane].to_bits() }
}

/// Changes the best hit of a lane.
#[inline(always)]
fn put_best<const ANY: bool>(hits: &mut [[f32; LANES]; 4], lane: usize, best: &Best) {
    let t = if ANY && best.is_hit() { f32::NEG_INFINITY } else { best.t };
    [hits[0][lane], hits[1][lane], hits[2][lane]] = [t, best.u, best.v];
    hits[3][lane] = f32::from_bits(best.primitive);
}

impl<'a, L: Lanes> Packet<'a, L> {
    /// # Safety
    /// The CPU has the instructions of `L`.
    #[inline(always)]
    unsafe fn new(tree: &KdTree, prepared: &'a Prepared<LANES>, base: usize, set: u32) -> Self {
        let lane = base + set.trailing_zeros() as usize;
        let axes = prepared.line(lane).axes;
        // SAFETY: `base` leaves enough lanes.
        unsafe {
            let nothing = L::splat(0.0);
            Self {
                prepared,
                base,
                set,
                way: prepared.way[lane] as usize,
                axes,
                inverse: load3(&prepared.inverse, base),
                early: load3(&prepared.early, base),
                late: load3(&prepared.late, base),
                origin: load3(&prepared.origin, base),
                shear: load3(&prepared.shear, base),
                t: L::load(prepared.t.as_ptr().add(base)),
                u: nothing,
                v: nothing,
                primitive: L::splat(f32::from_bits(super::NO_HIT)),
                bounds: LineBounds::new(tree, prepared, set << base, axes),
            }
        }
    }

    /// # Safety
    /// The CPU has the instructions of `L` and of `K`.
    #[inline(always)]
    unsafe fn walk<K: Kernel, const ANY: bool>(
        &mut self,
        tree: &KdTree,
        rays: &Rays,
        stack: &mut Stack,
        mut parking: Option<&mut Parking>,
    ) {
        // SAFETY: no way down has more splits than the stack has places; rows have places for all
        // lanes.
        unsafe {
            let Stack { later, steps, lanes: used, packets, alone } = stack;
            *packets += 1;
            let stack = later.as_mut_ptr();
            let mut depth = 0;
            let mut at = Node::ROOT;
            let mut lanes = self.set;
            let mut near = L::load(self.prepared.near.as_ptr().add(self.base));
            let mut far = L::load(self.prepared.far.as_ptr().add(self.base));
            loop {
                let mut node = *tree.nodes.get_unchecked(at);
                'down: {
                    while !node.is_leaf() {
                        if lanes.count_ones() <= FEW {
                            *alone += lanes.count_ones();
                            if let Some(parking) = &mut parking {
                                let stack = std::slice::from_raw_parts(stack, depth);
                                self.park(lanes, [near, far], at, stack, parking);
                            } else {
                                self.part::<K, ANY>(tree, rays, lanes, [near, far], at);
                            }
                            break 'down;
                        }
                        *steps += 1;
                        *used += lanes.count_ones();
                        let axis = node.axis();
                        let position = L::splat(node.position());
                        let early = position.mul_sub(self.inverse[axis], self.early[axis]);
                        let late = position.mul_sub(self.inverse[axis], self.late[axis]);
                        let falls = self.way >> axis & 1;
                        let first = node.lower_child() + falls;
                        let second = first ^ 1;
                        // So written that NaN skips nothing.
                        let mut visit_near = lanes & !late.lt(near);
                        let mut visit_far = lanes & !far.lt(early);
                        visit_near = if node.is_empty(falls) { 0 } else { visit_near };
                        visit_far = if node.is_empty(1 - falls) { 0 } else { visit_far };
                        if visit_near != 0 {
                            if visit_far != 0 {
                                let later = &mut *stack.add(depth);
                                early.max(near).store(later.near.as_mut_ptr());
                                far.store(later.far.as_mut_ptr());
                                (later.node, later.lanes) = (second, visit_far);
                                depth += 1;
                            }
                            far = late.min(far);
                            (at, lanes) = (first, visit_near);
                        } else if visit_far != 0 {
                            near = early.max(near);
                            (at, lanes) = (second, visit_far);
                        } else {
                            break 'down;
                        }
                        node = *tree.nodes.get_unchecked(at);
                    }
                    self.test_leaf::<ANY>(tree, rays, node, lanes);
                }
                loop {
                    if depth == 0 {
                        return;
                    }
                    depth -= 1;
                    let later = &*stack.add(depth);
                    near = L::load(later.near.as_ptr());
                    lanes = later.lanes & self.set & near.le(self.t);
                    if lanes != 0 {
                        far = self.t.min(L::load(later.far.as_ptr()));
                        at = later.node;
                        break;
                    }
                }
            }
        }
    }

    /// Tests all that is in a leaf.
    ///
    /// # Safety
    /// The CPU has the instructions of `L`.
    #[inline(always)]
    unsafe fn test_leaf<const ANY: bool>(
        &mut self,
        tree: &KdTree,
        rays: &Rays,
        leaf: Node,
        lanes: u32,
    ) {
        let mut chunk = leaf.chunk();
        if chunk.is_empty() {
            return;
        }
        let mut words = &tree.arena.words[leaf.offset()..];
        loop {
            // SAFETY: the caller's.
            unsafe { self.test_chunk::<ANY>(words, chunk, lanes) };
            if !chunk.is_followed() {
                return;
            }
            words = &words[chunk.end()..];
            if chunk.has_curved() {
                // SAFETY: the caller's.
                unsafe { self.test_curved::<ANY>(tree, rays, words, lanes) };
                return;
            }
            chunk = Chunk(words[0]);
            words = &words[1..];
        }
    }

    /// # Safety
    /// The CPU has the instructions of `L`.
    #[inline(always)]
    unsafe fn test_curved<const ANY: bool>(
        &mut self,
        tree: &KdTree,
        rays: &Rays,
        words: &[u32],
        lanes: u32,
    ) {
        // SAFETY: the caller's.
        unsafe {
            let mut hits = self.hits();
            for lane in lanes_of(lanes) {
                let mut best = best_of(&hits, lane);
                let index = self.prepared.index[self.base + lane] as usize;
                tree.test_curved(words, (rays, index), &mut best);
                put_best::<ANY>(&mut hits, lane, &best);
            }
            self.load(&hits);
        }
    }

    /// Which triangles of a chunk are not beside all rays.
    ///
    /// # Safety
    /// The CPU has the instructions of `L`; the words are those of a finished arena.
    #[inline(always)]
    unsafe fn among(&self, words: &[u32], chunk: Chunk) -> u32 {
        let (triangles, vertices) = (chunk.triangles(), chunk.vertices());
        if triangles < CULLED {
            return (1 << triangles) - 1;
        }
        let bounds = &self.bounds;
        // Vertices beyond the rays, and before them, across the two axes.
        let (mut beyond, mut before) = (0u64, 0u64);
        // SAFETY: a finished arena goes on for 64 words after the last chunk.
        unsafe {
            let rows = words.as_ptr().cast::<f32>();
            let mut base = 0;
            while base < vertices {
                // What follows the vertices, taken for numbers, is subnormal: many times slower on
                // some CPUs.
                let beyond_last = !((1u32 << (vertices - base).min(L::COUNT)) - 1);
                let zero = L::splat(0.0);
                let z = L::load(rows.add(self.axes[2] * vertices + base));
                let z = z.replace(beyond_last, zero);
                let z0 = z.sub(L::splat(bounds.origin[2][1]));
                let z1 = z.sub(L::splat(bounds.origin[2][0]));
                for k in 0..2 {
                    let x = L::load(rows.add(self.axes[k] * vertices + base));
                    let x = x.replace(beyond_last, zero);
                    let x0 = x.sub(L::splat(bounds.origin[k][1]));
                    let x1 = x.sub(L::splat(bounds.origin[k][0]));
                    let (s0, s1) = (L::splat(bounds.shear[k][0]), L::splat(bounds.shear[k][1]));
                    // Rounding is monotonic: these bound what the test makes of the corner.
                    let least = s0.neg_mul_add(z0, x0).min(s0.neg_mul_add(z1, x0));
                    let least = least.min(s1.neg_mul_add(z0, x0)).min(s1.neg_mul_add(z1, x0));
                    let most = s0.neg_mul_add(z0, x1).max(s0.neg_mul_add(z1, x1));
                    let most = most.max(s1.neg_mul_add(z0, x1)).max(s1.neg_mul_add(z1, x1));
                    let shift = 32 * k + base;
                    beyond |= u64::from(L::splat(bounds.clear).lt(least)) << shift;
                    before |= u64::from(most.lt(L::splat(-bounds.clear))) << shift;
                }
                base += L::COUNT;
            }
        }
        let mut set = 0;
        for i in 0..triangles {
            let [a, b, c] = corners_of(words, chunk, i);
            let all = |sides: u64| (sides >> a) & (sides >> b) & (sides >> c);
            let beside = (all(beyond) | all(before)) & (1 | 1 << 32) != 0;
            set |= u32::from(!beside) << i;
        }
        set
    }

    /// # Safety
    /// The CPU has the instructions of `L`; the words are those of a finished arena.
    #[inline(always)]
    unsafe fn test_chunk<const ANY: bool>(&mut self, words: &[u32], chunk: Chunk, lanes: u32) {
        let vertices = chunk.vertices();
        // SAFETY: the caller's.
        unsafe {
            for i in lanes_of(self.among(words, chunk)) {
                let places = corners_of(words, chunk, i);
                let mut corners = [[self.u; 3]; 3];
                for c in 0..3 {
                    for k in 0..3 {
                        let at = self.axes[k] * vertices + places[c];
                        corners[c][k] = L::splat(f32::from_bits(*words.get_unchecked(at)));
                    }
                }
                let tested = Tested::new(corners, self.origin, self.shear, self.t, lanes);
                if tested.hits == 0 {
                    continue;
                }
                let tested = tested.settle(|lane| {
                    let line = self.prepared.line(self.base + lane);
                    (line.sheared(), triangle_at(words, chunk, i))
                });
                self.keep::<ANY>(&tested, words[chunk.ids_at() + i]);
            }
        }
    }

    /// Keeps hits that are nearer than the best, or as near and of lower id.
    ///
    /// # Safety
    /// The CPU has the instructions of `L`.
    #[inline(always)]
    unsafe fn keep<const ANY: bool>(&mut self, tested: &Tested<L>, id: u32) {
        // SAFETY: the caller's; there are as many values as lanes, or more.
        unsafe {
            let mut better = tested.hits & tested.t.lt(self.t);
            let equal = tested.hits & !better;
            if equal != 0 {
                let mut ids = [0.0f32; LANES];
                self.primitive.store(ids.as_mut_ptr());
                for lane in lanes_of(equal) {
                    better |= u32::from(id < ids[lane].to_bits()) << lane;
                }
            }
            self.primitive = self.primitive.replace(better, L::splat(f32::from_bits(id)));
            if ANY {
                self.t = self.t.replace(better, L::splat(f32::NEG_INFINITY));
            } else {
                let [u, v] = tested.weights();
                self.t = self.t.replace(better, tested.t);
                self.u = self.u.replace(better, u);
                self.v = self.v.replace(better, v);
            }
        }
    }

    /// Best hits of all lanes.
    ///
    /// # Safety
    /// The CPU has the instructions of `L`.
    #[inline(always)]
    unsafe fn hits(&self) -> [[f32; LANES]; 4] {
        let mut hits = [[0.0; LANES]; 4];
        // SAFETY: there are as many values as lanes, or more.
        unsafe {
            self.t.store(hits[0].as_mut_ptr());
            self.u.store(hits[1].as_mut_ptr());
            self.v.store(hits[2].as_mut_ptr());
            self.primitive.store(hits[3].as_mut_ptr());
        }
        hits
    }

    /// Lets some lanes leave the packet, before a node, with what is on the stack for them.
    ///
    /// # Safety
    /// The CPU has the instructions of `L`.
    #[inline(always)]
    unsafe fn park(
        &mut self,
        lanes: u32,
        span: [L; 2],
        node: usize,
        stack: &[Later],
        parking: &mut Parking,
    ) {
        self.set &= !lanes;
        parking.lanes |= lanes << self.base;
        let mut spans = [[0.0; LANES]; 2];
        // SAFETY: the caller's; there are as many values as lanes, or more.
        let hits = unsafe {
            span[0].store(spans[0].as_mut_ptr());
            span[1].store(spans[1].as_mut_ptr());
            self.hits()
        };
        for lane in lanes_of(lanes) {
            let at = self.base + lane;
            parking.node[at] = node as u32;
            for (row, span) in parking.span.iter_mut().zip(&spans) {
                row[at] = span[lane];
            }
            for (row, hits) in parking.best.iter_mut().zip(&hits) {
                row[at] = hits[lane];
            }
            let mut top = 1;
            for later in stack {
                parking.later[top % (MAX_DEPTH + 2)][at] =
                    (later.node as u32, [later.near[lane], later.far[lane]]);
                top += (later.lanes >> lane & 1) as usize;
            }
            parking.top[at] = top as u32;
        }
    }

    /// Takes some lanes through a part of the tree, one by one.
    ///
    /// # Safety
    /// The CPU has the instructions of `L` and of `K`.
    #[inline(always)]
    unsafe fn part<K: Kernel, const ANY: bool>(
        &mut self,
        tree: &KdTree,
        rays: &Rays,
        lanes: u32,
        span: [L; 2],
        node: usize,
    ) {
        // SAFETY: the caller's; there are as many values as lanes, or more.
        unsafe {
            let mut spans = [[0.0; LANES]; 2];
            span[0].store(spans[0].as_mut_ptr());
            span[1].store(spans[1].as_mut_ptr());
            let mut hits = self.hits();
            for lane in lanes_of(lanes) {
                let mut best = best_of(&hits, lane);
                let visit = Visit { node, near: spans[0][lane], far: spans[1][lane] };
                let at = self.base + lane;
                let index = self.prepared.index[at] as usize;
                single::trace::<K, ANY, LANES>(
                    tree,
                    self.prepared,
                    at,
                    (rays, index),
                    visit,
                    &mut best,
                );
                put_best::<ANY>(&mut hits, lane, &best);
            }
            self.load(&hits);
        }
    }

    /// # Safety
    /// The CPU has the instructions of `L`.
    #[inline(always)]
    unsafe fn load(&mut self, hits: &[[f32; LANES]; 4]) {
        // SAFETY: there are as many values as lanes, or more.
        unsafe {
            self.t = L::load(hits[0].as_ptr());
            self.u = L::load(hits[1].as_ptr());
            self.v = L::load(hits[2].as_ptr());
            self.primitive = L::load(hits[3].as_ptr());
        }
    }

    /// # Safety
    /// The CPU has the instructions of `L`.
    #[inline(always)]
    unsafe fn finish(&self, done: &mut impl FnMut(usize, &Best)) {
        // SAFETY: the caller's.
        let hits = unsafe { self.hits() };
        for lane in lanes_of(self.set) {
            let best = best_of(&hits, lane);
            if best.is_hit() {
                done(self.prepared.index[self.base + lane] as usize, &best);
            }
        }
    }
}
