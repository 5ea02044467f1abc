//! The finished tree.

use super::leaf::Best;
use super::treelet::{Child, Stand, TOP, Treelet};
use crate::isa::Isa;
use crate::math::Bounds;
use crate::primitives::Primitives;
use crate::primitives::triangle::TriangleHit;
use crate::rays::Rays;
use crate::structure::shared::pages::Array;

/// Most planes on the way to a leaf.
pub(super) const MAX_DEPTH: usize = 60;

/// Trees of more bytes are far away: they are mostly outside the caches.
pub(super) const FAR: usize = 32 << 20;

/// A tree over primitives.
#[derive(Debug)]
pub(crate) struct KdTree {
    pub(super) primitives: Primitives,
    pub(super) bounds: Bounds,
    /// Treelets, then leaves.
    pub(super) lines: Array<Treelet>,
    /// Treelets on the longest way down.
    #[cfg_attr(not(target_arch = "x86_64"), allow(dead_code))]
    pub(super) depth: usize,
    /// Whether it is far away, beyond [`FAR`].
    #[cfg_attr(not(target_arch = "x86_64"), allow(dead_code))]
    pub(super) is_far: bool,
    pub(super) isa: Isa,
}

impl KdTree {
    /// Bytes of treelets and leaves.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.lines)
    }

    /// The lines as words.
    pub(super) fn words(&self) -> &[u32] {
        const { assert!(size_of::<Treelet>() == 64) };
        let len = self.bytes() / 4;
        // SAFETY: a treelet is sixteen words, without padding.
        unsafe { std::slice::from_raw_parts(self.lines.as_ptr().cast(), len) }
    }

    pub(super) fn treelet(&self, at: Child) -> &Treelet {
        &self.lines[at.line()]
    }

    /// Where every ray starts.
    pub(super) fn root(&self) -> Stand {
        self.treelet(Child::ROOT).at_plane(Child::ROOT, TOP)
    }

    /// Tests curved primitives, whose number and ids come first in `words`.
    #[cold]
    pub(super) fn test_curved(&self, words: &[u32], (rays, i): (&Rays, u32), best: &mut Best) {
        let first = self.primitives.triangles.len();
        let (origin, direction) = (rays.origin(i as usize), rays.direction(i as usize));
        for &id in &words[1..][..words[0] as usize] {
            let curved = &self.primitives.curved[id as usize - first];
            if let Some((t, part)) = curved.intersect(origin, direction, best.t.next_up()) {
                best.offer(TriangleHit { t, u: part.to_u(), v: 0.0 }, id);
            }
        }
    }
}
