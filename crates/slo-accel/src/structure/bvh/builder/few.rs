//! Subtrees of few primitives: of all splits between two centres, on each axis, the cheapest.
//!
//! For few primitives, bins would cost more than they save. The primitives are sorted once along
//! each axis; a split keeps the order of both sides.

use super::boxes::{Box8, Portable, Reference, Wide};
use super::heuristic::SAH_DEPTH;
use super::plan::{self, Subtree};
use super::tree::BinaryNode;
use crate::isa::Isa;
use crate::structure::bvh::layout::BLOCK;

/// Most primitives that are built here.
pub(super) const FEW: usize = 32;

/// Number of blocks that n primitives fill.
const BLOCKS: [f32; FEW + 1] = {
    let mut blocks = [0.0; FEW + 1];
    let mut n = 0;
    while n <= FEW {
        blocks[n] = n.div_ceil(BLOCK) as f32;
        n += 1;
    }
    blocks
};

/// Few primitives. A primitive's slot is its index on arrival.
pub(super) struct Few {
    slots: [Reference; FEW],
    /// Slots by centre on each axis; the first is the order of leaves in the end.
    order: [[u8; FEW]; 3],
    first_curved: u32,
    isa: Isa,
}

/// A subtree to be built.
#[derive(Clone, Copy)]
struct Range {
    begin: usize,
    end: usize,
    all: Box8,
    depth: u32,
}

impl Few {
    /// Builds the subtree over `references`, whose box is `all`, and puts them into its order.
    pub(super) fn build(
        references: &mut [Reference],
        nodes: &mut [BinaryNode],
        all: Box8,
        depth: u32,
        first_curved: u32,
        isa: Isa,
    ) -> Subtree {
        let n = references.len();
        let mut few =
            Self { slots: [Reference::NONE; FEW], order: [[0; FEW]; 3], first_curved, isa };
        few.slots[..n].copy_from_slice(references);
        few.sort(n);
        let subtree = few.grow(nodes, Range { begin: 0, end: n, all, depth });
        for (reference, &slot) in references.iter_mut().zip(&few.order[0]) {
            *reference = few.slots[usize::from(slot)];
        }
        subtree
    }

    fn sort(&mut self, n: usize) {
        let mut keys = [[0u64; FEW]; 3];
        for (slot, reference) in self.slots[..n].iter().enumerate() {
            let center = reference.center().to_array();
            for axis in 0..3 {
                keys[axis][slot] = u64::from(ordered(center[axis])) << 8 | slot as u64;
            }
        }
        for (keys, order) in keys.iter_mut().zip(&mut self.order) {
            keys[..n].sort_unstable();
            for (slot, key) in order.iter_mut().zip(&*keys) {
                *slot = *key as u8;
            }
        }
    }

    fn grow(&mut self, nodes: &mut [BinaryNode], range: Range) -> Subtree {
        let n = range.end - range.begin;
        if n <= BLOCK {
            return Handful::new(self, range.begin, range.end).build(self, nodes, range.begin);
        }
        let (middle, sides) = self.split(&range);
        let (node, below) = nodes.split_first_mut().expect("n - 1 nodes for n primitives");
        let (left_nodes, right_nodes) = below.split_at_mut(middle - range.begin - 1);
        let depth = range.depth + 1;
        let left = self.grow(left_nodes, Range { end: middle, all: sides[0], depth, ..range });
        let right = self.grow(right_nodes, Range { begin: middle, all: sides[1], depth, ..range });
        let (subtree, plan) = plan::combine(range.all.half_area(), n, &left, &right);
        *node = BinaryNode::new(&range.all, middle - range.begin, plan);
        subtree
    }

    /// Orders a range by its best split; returns where the right side begins, and both boxes.
    fn split(&mut self, range: &Range) -> (usize, [Box8; 2]) {
        let &Range { begin, end, .. } = range;
        let best = if range.depth < SAH_DEPTH { self.best(begin, end) } else { None };
        let halves = || (range.all.size().truncate().max_position(), (end - begin) / 2);
        let (axis, left) = best.unwrap_or_else(halves);
        let middle = begin + left;
        let (left, right) = self.order[axis][begin..end].split_at(left);
        let sides = [self.bounds(left), self.bounds(right)];
        let set = left.iter().fold(0, |set, slot| set | 1 << slot);
        for other in (0..3).filter(|&other| other != axis) {
            partition(&mut self.order[other][begin..end], set);
        }
        (middle, sides)
    }

    fn bounds(&self, slots: &[u8]) -> Box8 {
        let boxes = slots.iter().map(|&slot| self.slots[usize::from(slot)].bounds());
        boxes.fold(Box8::EMPTY, |all, bounds| all.union(bounds))
    }

    /// The axis of the cheapest split, and the number on the left; none if all costs overflow.
    fn best(&self, begin: usize, end: usize) -> Option<(usize, usize)> {
        let (mut least, mut place) = (f32::INFINITY, None);
        for axis in 0..3 {
            let order = &self.order[axis][begin..end];
            let (cost, left) = match self.isa {
                #[cfg(target_arch = "x86_64")]
                // SAFETY: the set is one that the CPU has.
                Isa::Avx512 | Isa::Avx2 => unsafe { sweep_avx2(&self.slots, order) },
                // SAFETY: plain Rust.
                _ => unsafe { sweep::<Portable>(&self.slots, order) },
            };
            if cost < least {
                (least, place) = (cost, Some((axis, left)));
            }
        }
        place
    }
}

/// The cheapest split of slots in their order: its cost, and the number on the left.
#[inline(always)]
unsafe fn sweep<W: Wide>(slots: &[Reference; FEW], order: &[u8]) -> (f32, usize) {
    let n = order.len();
    let mut right = [0.0; FEW];
    let mut best = (f32::INFINITY, 0);
    // SAFETY: the caller's.
    unsafe {
        let bounds = |i: usize| slots[usize::from(order[i]) % FEW].bounds();
        let mut all = W::load(&Box8::EMPTY);
        for i in (1..n).rev() {
            all = all.union(W::load(bounds(i)));
            right[i % FEW] = all.half_area() * BLOCKS[n - i];
        }
        let mut all = W::load(&Box8::EMPTY);
        for i in 1..n {
            all = all.union(W::load(bounds(i - 1)));
            let cost = all.half_area() * BLOCKS[i] + right[i % FEW];
            if cost < best.0 {
                best = (cost, i);
            }
        }
    }
    best
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
unsafe fn sweep_avx2(slots: &[Reference; FEW], order: &[u8]) -> (f32, usize) {
    // SAFETY: the caller's.
    unsafe { sweep::<std::arch::x86_64::__m256>(slots, order) }
}

/// Moves the slots of a set to the front; both sides keep their orders.
fn partition(slots: &mut [u8], set: u32) {
    let mut others = [0; FEW];
    let mut inside = 0;
    for i in 0..slots.len() {
        let slot = slots[i];
        slots[inside] = slot;
        others[i - inside] = slot;
        inside += (set >> slot & 1) as usize;
    }
    let rest = slots.len() - inside;
    slots[inside..].copy_from_slice(&others[..rest]);
}

/// Bits that order as the number does.
fn ordered(x: f32) -> u32 {
    let bits = x.to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
}

/// Up to [`BLOCK`] primitives, with the boxes and areas of all their subsets.
struct Handful {
    slots: [u8; BLOCK],
    boxes: [Box8; 1 << BLOCK],
    areas: [f32; 1 << BLOCK],
    curved: u32,
    count: usize,
}

impl Handful {
    fn new(few: &Few, begin: usize, end: usize) -> Self {
        let count = end - begin;
        let mut handful = Self {
            slots: [0; BLOCK],
            boxes: [Box8::EMPTY; 1 << BLOCK],
            areas: [0.0; 1 << BLOCK],
            curved: 0,
            count,
        };
        for i in 0..count {
            let slot = few.order[0][begin + i];
            let reference = &few.slots[usize::from(slot)];
            handful.slots[i] = slot;
            handful.curved |= u32::from(reference.id() >= few.first_curved) << i;
            for others in 0..1 << i {
                let all = handful.boxes[others].union(reference.bounds());
                handful.boxes[1 << i | others] = all;
                handful.areas[1 << i | others] = all.half_area();
            }
        }
        handful
    }

    fn build(&self, few: &mut Few, nodes: &mut [BinaryNode], begin: usize) -> Subtree {
        self.grow(few, nodes, begin, (1 << self.count) - 1)
    }

    fn grow(&self, few: &mut Few, nodes: &mut [BinaryNode], begin: usize, set: u32) -> Subtree {
        let area = self.areas[set as usize];
        let Some((node, below)) = nodes.split_first_mut() else {
            few.order[0][begin] = self.slots[set.trailing_zeros() as usize];
            return Subtree::single(area, self.curved & set != 0);
        };
        let left = self.split(set);
        let middle = left.count_ones() as usize;
        let (left_nodes, right_nodes) = below.split_at_mut(middle - 1);
        let right = self.grow(few, right_nodes, begin + middle, set ^ left);
        let left = self.grow(few, left_nodes, begin, left);
        let (subtree, plan) = plan::combine(area, set.count_ones() as usize, &left, &right);
        *node = BinaryNode::new(&self.boxes[set as usize], middle, plan);
        subtree
    }

    /// The left side of the best of all ways to split a set. The last primitive stays right.
    fn split(&self, set: u32) -> u32 {
        let rest = set & !(1 << set.ilog2());
        let (mut best, mut least) = (rest, f32::INFINITY);
        let mut left = rest;
        while left != 0 {
            let cost = self.areas[left as usize] + self.areas[(set ^ left) as usize];
            if cost < least {
                (best, least) = (left, cost);
            }
            left = (left - 1) & rest;
        }
        best
    }
}
