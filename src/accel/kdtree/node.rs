//! Nodes of 8 bytes.

/// What a node is: an inner node or a leaf, in two words.
///
/// | | word 0 | word 1, bits 0-1 | word 1, the other bits |
/// |---|---|---|---|
/// | inner | split position (f32) | axis, 0-2 | 2: lower child is empty; 3: upper child is; 4-31: the children's pair |
/// | leaf | offset of its first chunk in the arena | 3 | [`Chunk`] of it, 0 when empty |
///
/// The children of pair `i` are nodes `2 i`, the lower, and `2 i + 1`: both are in one cache line.
/// That a child is empty is told by its parent, so that no ray goes there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C, align(8))]
pub(super) struct Node {
    word: [u32; 2],
}

const LEAF: u32 = 3;

impl Node {
    /// The place of the root; its neighbour is never used.
    pub(super) const ROOT: usize = 0;
    /// A leaf without primitives.
    pub(super) const EMPTY: Self = Self { word: [0, LEAF] };
    /// Bit in word 1 of an inner node whose lower child is empty; the next one is for the upper.
    pub(super) const LOWER_IS_EMPTY: u32 = 1 << 2;
    pub(super) const UPPER_IS_EMPTY: u32 = 1 << 3;
    /// By how much word 1 of an inner node is shifted to tell its pair.
    pub(super) const PAIR_SHIFT: u32 = 4;

    pub(super) fn inner(axis: usize, position: f32, pair: usize, empty: [bool; 2]) -> Self {
        debug_assert!(pair >> (32 - Self::PAIR_SHIFT) == 0);
        let empty = (u32::from(empty[0]) * Self::LOWER_IS_EMPTY)
            | (u32::from(empty[1]) * Self::UPPER_IS_EMPTY);
        Self { word: [position.to_bits(), axis as u32 | empty | (pair as u32) << Self::PAIR_SHIFT] }
    }

    pub(super) fn leaf(offset: u32, first: Chunk) -> Self {
        Self { word: [offset, LEAF | first.0 << 2] }
    }

    /// From the two words.
    #[inline(always)]
    pub(super) fn of_words(word: [u32; 2]) -> Self {
        Self { word }
    }

    #[inline(always)]
    pub(super) fn is_leaf(self) -> bool {
        self.axis() == LEAF as usize
    }

    /// Split axis of an inner node.
    #[inline(always)]
    pub(super) fn axis(self) -> usize {
        (self.word[1] & 3) as usize
    }

    /// Split position of an inner node.
    #[inline(always)]
    pub(super) fn position(self) -> f32 {
        f32::from_bits(self.word[0])
    }

    /// Lower child of an inner node.
    #[inline(always)]
    pub(super) fn lower_child(self) -> usize {
        (self.word[1] >> Self::PAIR_SHIFT) as usize * 2
    }

    /// Whether the lower (0) or upper (1) child is empty.
    #[inline(always)]
    pub(super) fn is_empty(self, side: usize) -> bool {
        self.word[1] & (Self::LOWER_IS_EMPTY << side) != 0
    }

    /// Offset of a leaf's first chunk.
    #[inline(always)]
    pub(super) fn offset(self) -> usize {
        self.word[0] as usize
    }

    /// First chunk of a leaf.
    #[inline(always)]
    pub(super) fn chunk(self) -> Chunk {
        Chunk(self.word[1] >> 2)
    }

    /// The same node after `pairs` and `words` were put before its tree's.
    pub(super) fn moved(self, pairs: u32, words: u32) -> Self {
        if self.is_leaf() {
            Self { word: [self.word[0] + words, self.word[1]] }
        } else {
            Self { word: [self.word[0], self.word[1] + (pairs << Self::PAIR_SHIFT)] }
        }
    }
}
/// Up to 16 triangles of a leaf and what comes after them.
///
/// In the arena, in words of 4 bytes: the x, y, and z of its vertices; per triangle the three
/// vertices it joins, 5 bits each in 16; the triangles' ids. Then, if flagged, a count of curved
/// primitives and their ids; then, if flagged, the [`Chunk`] that follows and its contents.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(super) struct Chunk(pub(super) u32);

impl Chunk {
    pub(super) const MAX_TRIANGLES: usize = 16;
    pub(super) const MAX_VERTICES: usize = 32;
    const CURVED: u32 = 1 << 11;
    const MORE: u32 = 1 << 12;
    /// Bits of the number of triangles, of that of vertices, and of what tells that more follows.
    pub(super) const TRIANGLES: u32 = 31;
    pub(super) const VERTICES: u32 = 63 << 5;
    pub(super) const FOLLOWED: u32 = Self::CURVED | Self::MORE;

    pub(super) fn new(triangles: usize, vertices: usize, curved: bool, more: bool) -> Self {
        debug_assert!(triangles <= Self::MAX_TRIANGLES && vertices <= Self::MAX_VERTICES);
        let flags = (u32::from(curved) * Self::CURVED) | (u32::from(more) * Self::MORE);
        Self(triangles as u32 | (vertices as u32) << 5 | flags)
    }

    #[inline(always)]
    pub(super) fn is_empty(self) -> bool {
        self.0 == 0
    }

    #[inline(always)]
    pub(super) fn triangles(self) -> usize {
        (self.0 & 31) as usize
    }

    #[inline(always)]
    pub(super) fn vertices(self) -> usize {
        (self.0 >> 5 & 63) as usize
    }

    /// The bits of so many vertices.
    #[inline(always)]
    pub(super) fn vertices_bits(vertices: u32) -> u32 {
        vertices << 5
    }

    #[inline(always)]
    pub(super) fn has_curved(self) -> bool {
        self.0 & Self::CURVED != 0
    }

    /// Whether anything follows the triangles.
    #[inline(always)]
    pub(super) fn is_followed(self) -> bool {
        self.0 & Self::FOLLOWED != 0
    }

    /// Words of the vertices.
    #[inline(always)]
    pub(super) fn corners_at(self) -> usize {
        3 * self.vertices()
    }

    /// Words before the ids.
    #[inline(always)]
    pub(super) fn ids_at(self) -> usize {
        self.corners_at() + self.triangles().div_ceil(2)
    }

    /// Words before what follows the triangles.
    #[inline(always)]
    pub(super) fn end(self) -> usize {
        self.ids_at() + self.triangles()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_keep_what_they_are_given() {
        assert_eq!(size_of::<Node>(), 8);
        let inner = Node::inner(2, -1.5, 77, [false, true]);
        assert!(!inner.is_leaf() && !inner.is_empty(0) && inner.is_empty(1));
        assert_eq!((inner.axis(), inner.position(), inner.lower_child()), (2, -1.5, 154));
        assert_eq!(inner.moved(3, 100), Node::inner(2, -1.5, 80, [false, true]));
        let chunk = Chunk::new(16, 32, true, false);
        let leaf = Node::leaf(9, chunk);
        assert!(leaf.is_leaf());
        assert_eq!((leaf.offset(), leaf.chunk()), (9, chunk));
        assert_eq!(leaf.moved(3, 100), Node::leaf(109, chunk));
        assert_eq!((chunk.triangles(), chunk.vertices()), (16, 32));
        assert!(chunk.has_curved() && chunk.is_followed());
        assert!(Node::EMPTY.is_leaf() && Node::EMPTY.chunk().is_empty());
    }
}
