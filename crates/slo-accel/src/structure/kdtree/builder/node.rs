//! The nodes of a tree while it grows.

use crate::structure::kdtree::leaf::Chunk;

/// An inner node or a leaf, in two words.
///
/// | | word 0 | word 1, bits 0-1 | word 1, the other bits |
/// |---|---|---|---|
/// | inner | split position (f32) | axis, 0-2 | the children's pair |
/// | leaf | offset of its first chunk in the arena | 3 | that [`Chunk`], 0 when empty |
///
/// The children of pair `i` are nodes `2 i`, the lower, and `2 i + 1`.
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

    pub(super) fn inner(axis: usize, position: f32, pair: usize) -> Self {
        debug_assert!(pair >> 30 == 0);
        Self { word: [position.to_bits(), axis as u32 | (pair as u32) << 2] }
    }

    pub(super) fn leaf(offset: u32, first: Chunk) -> Self {
        Self { word: [offset, LEAF | first.0 << 2] }
    }

    pub(super) fn is_leaf(self) -> bool {
        self.axis() == LEAF as usize
    }

    /// Whether it is a leaf without primitives.
    pub(super) fn is_empty(self) -> bool {
        self.is_leaf() && self.chunk().is_empty()
    }

    /// Split axis of an inner node.
    pub(super) fn axis(self) -> usize {
        (self.word[1] & 3) as usize
    }

    /// Split position of an inner node.
    pub(super) fn position(self) -> f32 {
        f32::from_bits(self.word[0])
    }

    /// Children of an inner node, the lower first.
    pub(super) fn children(self) -> [usize; 2] {
        let lower = (self.word[1] >> 2) as usize * 2;
        [lower, lower + 1]
    }

    /// Offset of a leaf's first chunk.
    pub(super) fn offset(self) -> usize {
        self.word[0] as usize
    }

    /// First chunk of a leaf.
    pub(super) fn chunk(self) -> Chunk {
        Chunk(self.word[1] >> 2)
    }

    /// The same node after `pairs` and `words` were put before its tree's.
    pub(super) fn moved(self, pairs: u32, words: u32) -> Self {
        if self.is_leaf() {
            Self { word: [self.word[0] + words, self.word[1]] }
        } else {
            Self { word: [self.word[0], self.word[1] + (pairs << 2)] }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_keep_what_they_are_given() {
        assert_eq!(size_of::<Node>(), 8);
        let inner = Node::inner(2, -1.5, 77);
        assert!(!inner.is_leaf() && !inner.is_empty());
        assert_eq!((inner.axis(), inner.position(), inner.children()), (2, -1.5, [154, 155]));
        assert_eq!(inner.moved(3, 100), Node::inner(2, -1.5, 80));
        let chunk = Chunk::new(16, 32, true, false);
        let leaf = Node::leaf(8, chunk);
        assert!(leaf.is_leaf() && !leaf.is_empty());
        assert_eq!((leaf.offset(), leaf.chunk()), (8, chunk));
        assert_eq!(leaf.moved(3, 100), Node::leaf(108, chunk));
        assert!(Node::EMPTY.moved(3, 100).is_empty());
    }
}
