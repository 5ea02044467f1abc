//! Nodes and leaves of the hierarchy in memory.

use crate::math::{Bounds, rounding::UNIT_ROUNDOFF};
use crate::primitives::Triangle;
use crate::primitives::triangle::POSITION_ERROR;
use crate::structure::shared::pages::{Array, Plain};
use crate::structure::shared::stops::{self, Target};
use glam::Vec3;

/// Children of a node.
pub(super) const WIDTH: usize = 8;

/// Most triangles of a block, which are tested together.
pub(super) const BLOCK: usize = 4;

/// Widening of boxes and rays, in units of the largest coordinate. A hit may lie [`POSITION_ERROR`]
/// outside its triangle's box, and the test of a box makes eight roundings.
///
/// A hit's error is relative to the distance of the corners from the ray's origin, which is at most
/// the largest coordinate of the box plus the largest of the origin. The box is widened for the
/// first when it is stored, the ray for the second when it is prepared.
pub(super) const BOX_ERROR: f32 = POSITION_ERROR + 8.0 * UNIT_ROUNDOFF;

/// The same for boxes that move, and for corners that do: five more roundings of each, whose error
/// is up to twice the largest coordinate, and some to spare.
const MOVING_BOX_ERROR: f32 = BOX_ERROR + 16.0 * UNIT_ROUNDOFF;

/// Nodes in a row that make one node: if boxes move, the planes of the second tell how far they
/// do so over the time of the hierarchy, and its other fields mean nothing.
pub(super) const fn nodes_per_node(moves: bool) -> usize {
    if moves { 2 } else { 1 }
}

/// A node: boxes and names of eight children, in four cache lines.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// Lower and upper planes of x, then y, then z; lower is above upper if there is no child.
    pub(super) planes: [[f32; WIDTH]; 6],
    pub(super) children: [Child; WIDTH],
    /// Four bits for each octant of directions: in word `s` the child that is `s`-th, from far to
    /// near.
    pub(super) order: [u32; WIDTH],
}

// SAFETY: numbers without padding.
unsafe impl Plain for Node {}

impl Node {
    /// Whether nothing can enter the box of a child.
    pub(super) fn is_closed(&self, place: usize) -> bool {
        (0..3).all(|axis| {
            self.planes[2 * axis][place] == f32::INFINITY
                && self.planes[2 * axis + 1][place] == f32::NEG_INFINITY
        })
    }

    pub(super) const EMPTY: Self = Self {
        planes: [
            [f32::INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
            [f32::INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
            [f32::INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
        ],
        children: [Child::DONE; WIDTH],
        order: [
            0,
            0x1111_1111,
            0x2222_2222,
            0x3333_3333,
            0x4444_4444,
            0x5555_5555,
            0x6666_6666,
            0x7777_7777,
        ],
    };

    /// Sets a child, and widens its box.
    pub(super) fn set(&mut self, place: usize, child: Child, bounds: Bounds) {
        let largest = bounds.min.abs().max(bounds.max.abs()).max_element();
        let error = BOX_ERROR * largest;
        for axis in 0..3 {
            self.planes[2 * axis][place] = (bounds.min[axis] - error).next_down();
            self.planes[2 * axis + 1][place] = (bounds.max[axis] + error).next_up();
        }
        self.children[place] = child;
    }

    /// The second part of a node whose boxes move, before any child is set.
    pub(super) const AT_REST: Self = Self { planes: [[0.0; WIDTH]; 6], ..Self::EMPTY };

    /// Sets a child of a node whose boxes move, with its boxes at the start and at the end, and
    /// widens them.
    pub(super) fn set_moving(nodes: &mut [Self], place: usize, child: Child, boxes: [Bounds; 2]) {
        let [start, end] = boxes;
        let reach = |b: Bounds| b.min.abs().max(b.max.abs()).max_element();
        let error = MOVING_BOX_ERROR * reach(start).max(reach(end));
        for axis in 0..3 {
            let lower = [start, end].map(|b| (b.min[axis] - error).next_down());
            let upper = [start, end].map(|b| (b.max[axis] + error).next_up());
            for (side, [from, to]) in [lower, upper].into_iter().enumerate() {
                nodes[0].planes[2 * axis + side][place] = from;
                nodes[1].planes[2 * axis + side][place] = to - from;
            }
        }
        nodes[0].children[place] = child;
    }
}

/// Entries of the deepest stack, with room for one step's writing beyond it: a ray leaves at most
/// `WIDTH - 1` entries on each level, besides the first.
pub(super) fn stack_size(depth: usize) -> usize {
    1 + depth * (WIDTH - 1) + WIDTH
}

/// A node's child: another node, a block of triangles, or a curved surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub(super) struct Child(pub(super) u32);

impl Child {
    const LEAF: u32 = 1 << 31;
    const KIND_SHIFT: u32 = 28;
    const CURVED: u32 = 4;
    const INDEX: u32 = (1 << Self::KIND_SHIFT) - 1;

    /// The end of a stack: nothing is left to visit.
    pub(super) const DONE: Self = Self(u32::MAX);

    pub(super) fn node(index: u32) -> Self {
        Self(index)
    }

    /// One to four triangles from a slot on.
    pub(super) fn triangles(slot: u32, count: u32) -> Self {
        debug_assert!((1..=4).contains(&count));
        Self(Self::LEAF | (count - 1) << Self::KIND_SHIFT | slot)
    }

    pub(super) fn curved(index: u32) -> Self {
        Self(Self::LEAF | Self::CURVED << Self::KIND_SHIFT | index)
    }

    /// Whether it is not a node.
    #[inline(always)]
    pub(super) fn is_leaf(self) -> bool {
        self.0 >= Self::LEAF
    }

    /// Whether it is a block of triangles.
    #[inline(always)]
    pub(super) fn is_block(self) -> bool {
        self.kind() == Stops::BLOCKS
    }

    /// Which of the lists of [`Stops`] it belongs to.
    #[inline(always)]
    pub(super) fn kind(self) -> usize {
        const { assert!(Self::INDEX < 1 << 30 && Self::CURVED << Self::KIND_SHIFT == 1 << 30) };
        (self.0 >> 30) as usize
    }

    /// Index of the node, first slot, or index of the curved surface.
    #[inline(always)]
    pub(super) fn index(self) -> usize {
        (self.0 & Self::INDEX) as usize
    }

    /// How many triangles a block has, from 1.
    #[inline(always)]
    pub(super) fn block_len(self) -> usize {
        (self.0 >> Self::KIND_SHIFT & 3) as usize + 1
    }
}

impl Target for Child {
    #[inline(always)]
    fn word(self) -> u32 {
        self.0
    }

    #[inline(always)]
    fn of_word(word: u32) -> Self {
        Self(word)
    }
}

/// A ray in flight before a child.
pub(super) type Stop = stops::Stop<Child>;

/// Lists of rays in flight by the kind of their next visit.
pub(super) type Stops = stops::Stops<Child>;

impl Stops {
    /// Kinds: nodes, blocks of triangles, and the rest: curved surfaces and the end.
    pub(super) const NODES: usize = 0;
    pub(super) const BLOCKS: usize = 2;
    pub(super) const OTHERS: usize = 3;
}

/// Slots of triangles that a [`Place`] and a [`Child`] can name.
pub(super) const MAX_SLOTS: usize = 1 << 28;

/// The triangles, block by block in the order of leaves. A block of n triangles is ten rows of n:
/// x, y, and z of the first corners, then of the second, then of the third, then bits of ids. An id
/// thus lies in a line of memory that its triangle's test has just read. If corners move, nine rows
/// follow: by how much each of the first nine changes.
#[derive(Debug)]
pub(super) struct Corners {
    rows: Array<f32>,
    /// See [`rows_of`].
    per_triangle: usize,
}

/// Rows of a block: numbers for each triangle.
pub(super) const fn rows_of(moves: bool) -> usize {
    if moves { FIRST_CHANGE + 9 } else { FIRST_CHANGE }
}

/// The first row of a block that tells how a coordinate changes.
pub(super) const FIRST_CHANGE: usize = 10;

impl Corners {
    /// Elements that are readable beyond the last row, so that four lanes can be loaded.
    pub(super) const PADDING: usize = 4;

    /// Room for `count` triangles.
    pub(super) fn new(count: usize, moves: bool) -> Self {
        let per_triangle = rows_of(moves);
        Self { rows: Array::filled(0.0, count * per_triangle + Self::PADDING), per_triangle }
    }

    pub(super) fn rows_mut(&mut self) -> &mut [f32] {
        let count = self.rows.len() - Self::PADDING;
        &mut self.rows[..count]
    }

    pub(super) fn rows(&self) -> &[f32] {
        &self.rows
    }

    /// Number of triangles that there is room for.
    pub(super) fn slots(&self) -> usize {
        (self.rows.len() - Self::PADDING) / self.per_triangle
    }

    /// The id of a triangle of the block of `count` that begins at `slot`.
    pub(super) fn id(&self, slot: usize, count: usize, lane: usize) -> u32 {
        self.rows[slot * self.per_triangle + ID_ROW * count + lane].to_bits()
    }

    /// One triangle of the block of `count` that begins at `slot`; as it is at first, if it moves.
    #[inline]
    pub(super) fn triangle(&self, slot: usize, count: usize, lane: usize) -> Triangle {
        block_triangle(&self.rows[slot * self.per_triangle..], count, lane)
    }

    /// One triangle of the block of `count` that begins at `slot`, at a time from 0 to 1.
    #[inline]
    pub(super) fn triangle_at(
        &self,
        slot: usize,
        count: usize,
        lane: usize,
        time: f32,
    ) -> Triangle {
        let rows = &self.rows[slot * self.per_triangle..];
        if self.per_triangle == rows_of(true) {
            moved_triangle(rows, count, lane, time)
        } else {
            block_triangle(rows, count, lane)
        }
    }
}

/// One triangle of a block of `count` that `rows` begins with.
#[inline(always)]
pub(super) fn block_triangle(rows: &[f32], count: usize, lane: usize) -> Triangle {
    std::array::from_fn(|corner| {
        Vec3::from_array(std::array::from_fn(|axis| rows[(3 * corner + axis) * count + lane]))
    })
}

/// The same at a time from 0 to 1, if corners move.
#[inline(always)]
pub(super) fn moved_triangle(rows: &[f32], count: usize, lane: usize, time: f32) -> Triangle {
    let start = block_triangle(rows, count, lane);
    let change = block_triangle(&rows[FIRST_CHANGE * count..], count, lane);
    std::array::from_fn(|corner| start[corner] + change[corner] * time)
}

/// The row of a block that holds ids.
pub(super) const ID_ROW: usize = 9;

/// The id of a triangle of the block of `count` that begins at `block`.
///
/// # Safety
/// There is such a block.
#[inline(always)]
pub(super) unsafe fn id_at(block: *const f32, count: usize, lane: usize) -> u32 {
    // SAFETY: the caller's.
    unsafe { *block.add(ID_ROW * count + lane).cast() }
}

/// One triangle of the block of `count` that begins at `block`, at a time from 0 to 1 if corners
/// move.
///
/// # Safety
/// There is such a block.
#[inline(always)]
pub(super) unsafe fn triangle_at(
    block: *const f32,
    count: usize,
    lane: usize,
    time: Option<f32>,
) -> Triangle {
    // SAFETY: the caller's.
    let rows = unsafe { std::slice::from_raw_parts(block, count * rows_of(time.is_some())) };
    match time {
        Some(time) => moved_triangle(rows, count, lane, time),
        None => block_triangle(rows, count, lane),
    }
}

/// Place of a triangle: slot of its block, number of triangles there, and its lane.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Place(pub(super) u32);

impl Place {
    pub(super) fn new(slot: u32, count: u32, lane: u32) -> Self {
        Self(slot << 4 | (count - 1) << 2 | lane)
    }

    #[inline]
    pub(super) fn slot(self) -> usize {
        (self.0 >> 4) as usize
    }

    #[inline]
    pub(super) fn count(self) -> usize {
        (self.0 >> 2 & 3) as usize + 1
    }

    #[inline]
    pub(super) fn lane(self) -> usize {
        (self.0 & 3) as usize
    }
}
