//! Treelets: three levels of the tree in a cache line.

use super::leaf::Chunk;
#[cfg(target_arch = "x86_64")]
use crate::structure::shared::stops;
use crate::structure::shared::stops::Target;

/// Children of a treelet.
pub(super) const WIDTH: usize = 8;

/// Up to seven planes, and the eight cells between them.
///
/// Child `c` lies above the root's plane if bit 2 of `c` is set, above that of the next level if
/// bit 1 is, and above that of the last if bit 0 is. If a subtree ends early, its planes are NaN,
/// which excludes no ray; its one child comes first, the others are empty.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub(super) struct Treelet {
    /// Positions: of the four planes of the last level, of the two of the one before, of the
    /// root's.
    pub(super) planes: [f32; WIDTH - 1],
    /// Two bits for the axis of each plane, in the same order; then two bits for each plane, set if
    /// the lower or the upper side is empty.
    pub(super) axes: u32,
    pub(super) children: [Child; WIDTH],
}

/// The place of the root's plane, and of the first of the level below it.
pub(super) const TOP: usize = 6;
pub(super) const MIDDLE: usize = 4;

/// The first bit of emptiness.
const EMPTY_SHIFT: usize = 14;

impl Treelet {
    /// Nothing.
    pub(super) const EMPTY: Self =
        Self { planes: [f32::NAN; WIDTH - 1], axes: 0, children: [Child::EMPTY; WIDTH] };

    /// Sets a plane.
    pub(super) fn set_plane(&mut self, plane: usize, axis: usize, position: f32, empty: [bool; 2]) {
        self.planes[plane] = position;
        let empty = u32::from(empty[0]) | u32::from(empty[1]) << 1;
        self.axes |= (axis as u32) << (2 * plane) | empty << (EMPTY_SHIFT + 2 * plane);
    }

    #[inline(always)]
    pub(super) fn axis(&self, plane: usize) -> usize {
        (self.axes >> (2 * plane) & 3) as usize
    }

    /// Whether nothing lies below a plane (side 0), or above it.
    #[inline(always)]
    pub(super) fn is_empty(&self, plane: usize, side: usize) -> bool {
        self.axes >> (EMPTY_SHIFT + 2 * plane + side) & 1 == 1
    }

    /// The part of the tree on a side of a plane of the treelet at `at`.
    #[inline(always)]
    pub(super) fn beyond(&self, at: Child, plane: usize, side: usize) -> Stand {
        if plane < MIDDLE {
            return Stand { at: self.children[2 * plane + side], plane: TOP };
        }
        self.at_plane(at, 2 * plane - 2 * MIDDLE + side)
    }

    /// A plane of the treelet at `at`, or the child that takes its place.
    #[inline(always)]
    pub(super) fn at_plane(&self, at: Child, plane: usize) -> Stand {
        if self.planes[plane].is_nan() {
            let first = cells_of(plane).trailing_zeros() as usize;
            return Stand { at: self.children[first % WIDTH], plane: TOP };
        }
        Stand { at, plane }
    }
}

/// A set of the children below and above a plane: bit `c` for child `c`.
#[inline(always)]
pub(super) fn cells_of(plane: usize) -> u8 {
    const CELLS: [u8; WIDTH - 1] = [0x03, 0x0c, 0x30, 0xc0, 0x0f, 0xf0, 0xff];
    CELLS[plane % CELLS.len()]
}

/// A part of the tree: below a plane of a treelet, or a leaf.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stand {
    pub(super) at: Child,
    /// [`TOP`] before a leaf.
    pub(super) plane: usize,
}

/// A child of a treelet: another treelet, a leaf of one of three sizes, or nothing.
///
/// The two highest bits are the kind, the others its place, in units of 16 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub(super) struct Child(pub(super) u32);

impl Child {
    const KIND_SHIFT: u32 = 30;
    const PLACE: u32 = (1 << Self::KIND_SHIFT) - 1;

    /// Words of a unit.
    pub(super) const UNIT: usize = 4;

    /// The root is the child of none.
    pub(super) const ROOT: Self = Self(0);
    pub(super) const EMPTY: Self = Self(0);
    /// The end of a stack: nothing is left to visit.
    #[cfg_attr(not(target_arch = "x86_64"), allow(dead_code))]
    pub(super) const DONE: Self = Self(u32::MAX);

    /// Kinds: treelets; leaves of one chunk that fill no more than a quarter of a register of 16,
    /// or more of it; the rest: leaves of more than that, and the end.
    pub(super) const TREELETS: usize = 0;
    pub(super) const QUARTERS: usize = 1;
    pub(super) const WHOLES: usize = 2;
    pub(super) const OTHERS: usize = 3;

    /// The treelet in a cache line.
    pub(super) fn treelet(line: usize) -> Self {
        let unit = line * (size_of::<Treelet>() / (4 * Self::UNIT));
        debug_assert!(unit <= Self::PLACE as usize);
        Self(unit as u32)
    }

    /// The leaf whose first chunk is at a word.
    pub(super) fn leaf(chunk: Chunk, word: usize) -> Self {
        debug_assert!(word.is_multiple_of(Self::UNIT));
        debug_assert!(word / Self::UNIT < Self::PLACE as usize);
        let kind = match chunk {
            _ if chunk.is_followed() => Self::OTHERS,
            _ if chunk.fits_in_quarter() => Self::QUARTERS,
            _ => Self::WHOLES,
        };
        Self((kind as u32) << Self::KIND_SHIFT | (word / Self::UNIT) as u32)
    }

    #[inline(always)]
    pub(super) fn kind(self) -> usize {
        (self.0 >> Self::KIND_SHIFT) as usize
    }

    #[inline(always)]
    pub(super) fn is_treelet(self) -> bool {
        self.kind() == Self::TREELETS
    }

    /// The word at which it begins.
    #[inline(always)]
    pub(super) fn offset(self) -> usize {
        (self.0 & Self::PLACE) as usize * Self::UNIT
    }

    /// The cache line of a treelet.
    #[inline(always)]
    pub(super) fn line(self) -> usize {
        self.offset() / (size_of::<Treelet>() / 4)
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
#[cfg(target_arch = "x86_64")]
pub(super) type Stop = stops::Stop<Child>;

/// Lists of rays in flight by the kind of their next visit.
#[cfg(target_arch = "x86_64")]
pub(super) type Stops = stops::Stops<Child>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn children_keep_what_they_are_given() {
        assert_eq!(size_of::<Treelet>(), 64);
        let treelet = Child::treelet(77);
        assert!(treelet.is_treelet());
        assert_eq!((treelet.line(), treelet.offset()), (77, 77 * 16));
        assert_eq!(Child::treelet(0), Child::ROOT);
        for (chunk, kind) in [
            (Chunk::new(4, 8, false, false), Child::QUARTERS),
            (Chunk::new(4, 9, false, false), Child::WHOLES),
            (Chunk::new(5, 8, false, false), Child::WHOLES),
            (Chunk::new(16, 32, false, false), Child::WHOLES),
            (Chunk::new(1, 3, true, false), Child::OTHERS),
            (Chunk::new(1, 3, false, true), Child::OTHERS),
        ] {
            let leaf = Child::leaf(chunk, 4004);
            assert_eq!((leaf.kind(), leaf.offset()), (kind, 4004));
        }
        assert_eq!(Child::DONE.kind(), Child::OTHERS);
    }

    #[test]
    fn sides_of_planes_are_below_them() {
        let mut treelet = Treelet::EMPTY;
        treelet.children = std::array::from_fn(|c| Child::treelet(100 + c));
        treelet.set_plane(TOP, 1, 0.5, [false, true]);
        treelet.set_plane(MIDDLE, 2, 0.25, [false, false]);
        treelet.set_plane(1, 0, 0.75, [true, false]);
        let at = Child::treelet(9);
        let told = |stand: Stand| (stand.at.line(), stand.plane);
        assert_eq!(told(treelet.beyond(at, TOP, 0)), (9, MIDDLE));
        assert_eq!(told(treelet.beyond(at, TOP, 1)), (104, TOP));
        assert_eq!(told(treelet.beyond(at, MIDDLE, 0)), (100, TOP));
        assert_eq!(told(treelet.beyond(at, MIDDLE, 1)), (9, 1));
        assert_eq!(told(treelet.beyond(at, 1, 1)), (103, TOP));
        assert_eq!([TOP, MIDDLE, 1].map(|plane| treelet.axis(plane)), [1, 2, 0]);
        assert!(treelet.is_empty(TOP, 1) && !treelet.is_empty(TOP, 0) && treelet.is_empty(1, 0));
    }
}
