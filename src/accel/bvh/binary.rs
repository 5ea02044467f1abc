//! The binary hierarchy that the wide one is made of: split by the surface area heuristic over
//! bins, down to single primitives.
//!
//! Source: Wald, *On fast construction of SAH-based bounding volume hierarchies* (2007). A leaf
//! costs what its blocks of [`BLOCK`] primitives cost. Which subtrees become leaves and which
//! nodes melt together is planned on the way back up ([`plan`]).

use glam::{BVec4A, Vec3, Vec4};
use rayon::prelude::*;

use super::plan::{self, Plan, Subtree};
use crate::math::Bounds;

/// Primitives that one step tests together.
pub(super) const BLOCK: usize = 4;

/// Below this depth nodes are halved, so that no input gives more than `SAH_DEPTH + 32` levels.
const SAH_DEPTH: u32 = 48;

/// Bins along each axis.
const BINS: usize = 16;

/// Subtrees with more primitives are worth a task of their own.
const PARALLEL_SUBTREE: usize = 2048;

/// Nodes with more primitives bin them in parallel, in chunks of this many.
const PARALLEL_CHUNK: usize = 1 << 15;

/// The box of a primitive, with the halves of its id in the fourth lanes: exact in f32.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reference {
    min: Vec4,
    max: Vec4,
}

impl Reference {
    pub(super) fn new(bounds: Bounds, id: u32) -> Self {
        Self {
            min: bounds.min.extend((id >> 16) as f32),
            max: bounds.max.extend((id & 0xffff) as f32),
        }
    }

    pub(super) fn id(&self) -> u32 {
        (self.min.w as u32) << 16 | self.max.w as u32
    }

    #[inline(always)]
    fn center(&self) -> Vec4 {
        0.5 * self.min + 0.5 * self.max
    }
}

/// A box under construction; the fourth lanes mean nothing.
#[derive(Clone, Copy, Debug)]
struct Box4 {
    min: Vec4,
    max: Vec4,
}

impl Box4 {
    const EMPTY: Self = Self { min: Vec4::INFINITY, max: Vec4::NEG_INFINITY };

    #[inline(always)]
    fn grow(&mut self, other: Self) {
        self.min = self.min.min(other.min);
        self.max = self.max.max(other.max);
    }

    #[inline(always)]
    fn union(mut self, other: Self) -> Self {
        self.grow(other);
        self
    }

    #[inline(always)]
    fn half_area(&self) -> f32 {
        let d = self.max - self.min;
        d.x * (d.y + d.z) + d.y * d.z
    }

    fn bounds(&self) -> Bounds {
        Bounds { min: self.min.truncate(), max: self.max.truncate() }
    }
}

/// A node of the binary hierarchy, stored before its children. A node over n primitives takes
/// `2 n - 1` places: itself, then its left child's nodes, then its right child's.
#[derive(Clone, Copy, Debug)]
pub(super) struct BinaryNode {
    pub(super) min: Vec3,
    /// How many primitives lie below.
    pub(super) count: u32,
    pub(super) max: Vec3,
    /// Where they begin in the order of leaves.
    pub(super) first: u32,
    /// What becomes of it in the wide hierarchy.
    pub(super) plan: Plan,
}

impl BinaryNode {
    const UNBUILT: Self =
        Self { min: Vec3::ZERO, count: 0, max: Vec3::ZERO, first: 0, plan: Plan::LEAF };

    pub(super) fn bounds(&self) -> Bounds {
        Bounds { min: self.min, max: self.max }
    }
}

/// A binary hierarchy with its plan.
pub(super) struct BinaryTree {
    /// The root first; empty where there are no primitives.
    pub(super) nodes: Vec<BinaryNode>,
    /// The primitives in the order of leaves.
    pub(super) references: Vec<Reference>,
}

impl BinaryTree {
    /// Builds the hierarchy; ids from `first_curved` are of curved surfaces, which never share a
    /// leaf.
    pub(super) fn build(mut references: Vec<Reference>, first_curved: u32) -> Self {
        let n = references.len();
        let mut nodes = vec![BinaryNode::UNBUILT; (2 * n).saturating_sub(1)];
        if n > 0 {
            let (all, centers) = extent(&references);
            let job = Job { all, centers, first: 0, depth: 0, first_curved };
            job.build(&mut references, &mut nodes);
        }
        Self { nodes, references }
    }

    /// The children of an inner node.
    pub(super) fn children(&self, node: u32) -> [u32; 2] {
        let left = node + 1;
        [left, node + 2 * self.nodes[left as usize].count]
    }

    pub(super) fn node(&self, index: u32) -> &BinaryNode {
        &self.nodes[index as usize]
    }
}

/// One subtree to be built.
struct Job {
    all: Box4,
    centers: Box4,
    first: u32,
    depth: u32,
    first_curved: u32,
}

impl Job {
    fn build(self, references: &mut [Reference], nodes: &mut [BinaryNode]) -> Subtree {
        let (node, below) = nodes.split_first_mut().expect("2 n - 1 nodes for n primitives");
        let count = references.len() as u32;
        let (subtree, plan) = if let [only] = references {
            let curved = only.id() >= self.first_curved;
            (Subtree::single(self.all.half_area(), curved), Plan::LEAF)
        } else {
            let (left, right) = self.build_children(references, below);
            plan::combine(self.all.half_area(), count, &left, &right)
        };
        let Bounds { min, max } = self.all.bounds();
        *node = BinaryNode { min, count, max, first: self.first, plan };
        subtree
    }

    fn build_children(
        &self,
        references: &mut [Reference],
        nodes: &mut [BinaryNode],
    ) -> (Subtree, Subtree) {
        let (middle, [left, right]) = self.split(references);
        let parallel = references.len() > PARALLEL_SUBTREE;
        let (left_refs, right_refs) = references.split_at_mut(middle);
        let (left_nodes, right_nodes) = nodes.split_at_mut(2 * middle - 1);
        let build_left = || left.build(left_refs, left_nodes);
        let build_right = || right.build(right_refs, right_nodes);
        if parallel { rayon::join(build_left, build_right) } else { (build_left(), build_right()) }
    }

    /// Sorts the primitives to both sides of the best split.
    fn split(&self, references: &mut [Reference]) -> (usize, [Job; 2]) {
        if references.len() <= BLOCK {
            let (middle, sides) = split_few(references);
            return (middle, self.children(middle, sides, [Box4::EMPTY; 2]));
        }
        if self.depth < SAH_DEPTH {
            let binning = Binning::new(&self.centers);
            if let Some(split) = best_split(&binning, references) {
                let (middle, centers) = partition(references, &binning, &split);
                if 0 < middle && middle < references.len() {
                    return (middle, self.children(middle, split.sides, centers));
                }
            }
        }
        let middle = halve(references, &self.centers);
        let (left, right) = (extent(&references[..middle]), extent(&references[middle..]));
        (middle, self.children(middle, [left.0, right.0], [left.1, right.1]))
    }

    fn children(&self, middle: usize, all: [Box4; 2], centers: [Box4; 2]) -> [Job; 2] {
        [0, 1].map(|side| Job {
            all: all[side],
            centers: centers[side],
            first: self.first + if side == 0 { 0 } else { middle as u32 },
            depth: self.depth + 1,
            first_curved: self.first_curved,
        })
    }
}

/// The best of all ways to split 2 to [`BLOCK`] primitives, each of which is one block on each
/// side: how many go left, and both boxes.
fn split_few(references: &mut [Reference]) -> (usize, [Box4; 2]) {
    let n = references.len();
    let mut best = (f32::INFINITY, 1, [Box4::EMPTY; 2]);
    // The last primitive stays right; the others go left by the bits of a number.
    for ways in 1u32..1 << (n - 1) {
        let mut sides = [Box4::EMPTY; 2];
        for (i, r) in references.iter().enumerate() {
            let side = usize::from(ways >> i & 1 == 0);
            sides[side].grow(Box4 { min: r.min, max: r.max });
        }
        let cost = sides[0].half_area() + sides[1].half_area();
        if cost < best.0 || ways == 1 {
            best = (cost, ways, sides);
        }
    }
    let mut middle = 0;
    for i in 0..n {
        if best.1 >> i & 1 == 1 {
            references.swap(i, middle);
            middle += 1;
        }
    }
    (middle, best.2)
}

/// Boxes about primitives and about their centres.
fn extent(references: &[Reference]) -> (Box4, Box4) {
    references.iter().fold((Box4::EMPTY, Box4::EMPTY), |(all, centers), r| {
        let center = r.center();
        (
            all.union(Box4 { min: r.min, max: r.max }),
            centers.union(Box4 { min: center, max: center }),
        )
    })
}

/// Halves the primitives by their centres along the widest axis, the lower ids first among equals.
fn halve(references: &mut [Reference], centers: &Box4) -> usize {
    let axis = (centers.max - centers.min).truncate().max_position();
    let middle = references.len() / 2;
    references.select_nth_unstable_by(middle, |a, b| {
        a.center()[axis].total_cmp(&b.center()[axis]).then(a.id().cmp(&b.id()))
    });
    middle
}

/// Which bin a centre lies in, on each axis.
struct Binning {
    min: Vec4,
    scale: Vec4,
}

impl Binning {
    fn new(centers: &Box4) -> Self {
        let size = centers.max - centers.min;
        // Finite and not 0, or every primitive falls into the first bin.
        let usable = size.cmpgt(Vec4::splat(f32::MIN_POSITIVE * BINS as f32))
            & size.cmplt(Vec4::splat(f32::INFINITY));
        let scale = Vec4::select(usable, Vec4::splat(BINS as f32 * 0.999_999) / size, Vec4::ZERO);
        Self { min: centers.min, scale: scale.with_w(0.0) }
    }

    /// Adding 2^23 to a number below it leaves the rounded number in the low bits.
    #[inline(always)]
    fn bins(&self, center: Vec4) -> [usize; 3] {
        const ROUNDER: Vec4 = Vec4::splat(8_388_608.0);
        let place = (center - self.min) * self.scale - Vec4::splat(0.5);
        let bits = place.max(Vec4::ZERO) + ROUNDER;
        [bits.x, bits.y, bits.z].map(|b| b.to_bits() as usize % BINS)
    }
}

/// Boxes and counts of the bins of three axes.
#[derive(Clone)]
struct Bins {
    boxes: [[Box4; BINS]; 3],
    counts: [[u32; BINS]; 3],
}

impl Bins {
    const EMPTY: Self = Self { boxes: [[Box4::EMPTY; BINS]; 3], counts: [[0; BINS]; 3] };

    fn fill(binning: &Binning, references: &[Reference]) -> Self {
        let mut bins = Self::EMPTY;
        for r in references {
            let places = binning.bins(r.center());
            for (axis, place) in places.into_iter().enumerate().take(3) {
                bins.boxes[axis][place].grow(Box4 { min: r.min, max: r.max });
                bins.counts[axis][place] += 1;
            }
        }
        bins
    }

    fn merge(mut self, other: &Self) -> Self {
        for axis in 0..3 {
            for bin in 0..BINS {
                self.boxes[axis][bin].grow(other.boxes[axis][bin]);
                self.counts[axis][bin] += other.counts[axis][bin];
            }
        }
        self
    }

    /// The cheapest split along one axis.
    fn sweep(&self, axis: usize) -> Split {
        let (boxes, counts) = (&self.boxes[axis], &self.counts[axis]);
        let mut right = [(Box4::EMPTY, 0.0f32); BINS];
        let (mut all, mut count) = (Box4::EMPTY, 0);
        for bin in (1..BINS).rev() {
            all.grow(boxes[bin]);
            count += counts[bin];
            right[bin] = (all, cost(&all, count));
        }
        let mut best = Split { cost: f32::INFINITY, axis, bin: 0, sides: [Box4::EMPTY; 2] };
        let (mut all, mut count) = (Box4::EMPTY, 0);
        for bin in 1..BINS {
            all.grow(boxes[bin - 1]);
            count += counts[bin - 1];
            let cost = cost(&all, count) + right[bin].1;
            if cost < best.cost {
                best = Split { cost, axis, bin, sides: [all, right[bin].0] };
            }
        }
        best
    }
}

/// Infinite for an empty side, so that no split has one.
#[inline(always)]
fn cost(all: &Box4, count: u32) -> f32 {
    if count == 0 { f32::INFINITY } else { all.half_area() * count.div_ceil(BLOCK as u32) as f32 }
}

/// Primitives whose bin on an axis is below `bin` go left.
struct Split {
    cost: f32,
    axis: usize,
    bin: usize,
    sides: [Box4; 2],
}

fn best_split(binning: &Binning, references: &[Reference]) -> Option<Split> {
    let bins = if references.len() > 2 * PARALLEL_CHUNK {
        let chunks: Vec<Bins> =
            references.par_chunks(PARALLEL_CHUNK).map(|c| Bins::fill(binning, c)).collect();
        chunks.iter().fold(Bins::EMPTY, |all, chunk| all.merge(chunk))
    } else {
        Bins::fill(binning, references)
    };
    let [x, y, z] = [0, 1, 2].map(|axis| bins.sweep(axis));
    let best = if x.cost <= y.cost && x.cost <= z.cost {
        x
    } else if y.cost <= z.cost {
        y
    } else {
        z
    };
    (best.cost < f32::INFINITY).then_some(best)
}

/// Moves the left primitives to the front; how many there are, and the boxes of both sides'
/// centres.
fn partition(references: &mut [Reference], binning: &Binning, split: &Split) -> (usize, [Box4; 2]) {
    let (mut left, mut right) = (Box4::EMPTY, Box4::EMPTY);
    let mut middle = 0;
    for i in 0..references.len() {
        let center = references[i].center();
        let is_left = binning.bins(center)[split.axis] < split.bin;
        // NaN on the left of min and max gives way to what is there.
        let to_left = Vec4::select(BVec4A::splat(is_left), center, Vec4::NAN);
        let to_right = Vec4::select(BVec4A::splat(is_left), Vec4::NAN, center);
        left = Box4 { min: to_left.min(left.min), max: to_left.max(left.max) };
        right = Box4 { min: to_right.min(right.min), max: to_right.max(right.max) };
        references.swap(i, middle);
        middle += usize::from(is_left);
    }
    (middle, [left, right])
}
