//! Leaves: how they are packed, and their test in plain Rust.

use glam::Vec3;

use crate::primitives::triangle::{self, ShearedRay, Triangle, TriangleHit};
use crate::rays::NO_HIT;

/// Up to 16 triangles of a leaf, and what follows them.
///
/// In memory, in words of 4 bytes: the chunk itself; the x, y, and z of its vertices; per triangle
/// the three vertices it joins, 5 bits each in 16; the triangles' ids. Then, if flagged, a count of
/// curved primitives and their ids; or, if flagged, the [`Chunk`] that follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(super) struct Chunk(pub(super) u32);

impl Chunk {
    pub(super) const MAX_TRIANGLES: usize = 16;
    pub(super) const MAX_VERTICES: usize = 32;
    const CURVED: u32 = 1 << 11;
    const MORE: u32 = 1 << 12;
    const FOLLOWED: u32 = Self::CURVED | Self::MORE;

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

    /// Whether four such chunks fit into a register of 16 triangles and two of vertices.
    pub(super) fn fits_in_quarter(self) -> bool {
        self.triangles() <= Self::MAX_TRIANGLES / 4 && self.vertices() <= Self::MAX_VERTICES / 4
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

    /// Words of the vertices: all words are counted from the one behind the chunk.
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

/// The nearest hit so far; `t` is the largest distance that still counts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Best {
    pub(super) t: f32,
    pub(super) u: f32,
    pub(super) v: f32,
    pub(super) primitive: u32,
}

impl Best {
    /// No hit yet, of a ray whose hits up to `t` count.
    #[inline(always)]
    pub(super) fn up_to(t: f32) -> Self {
        Self { t, u: 0.0, v: 0.0, primitive: NO_HIT }
    }

    /// Takes a hit that is nearer, or as near with a lower id.
    #[inline(always)]
    pub(super) fn offer(&mut self, hit: TriangleHit, primitive: u32) {
        if hit.t < self.t || (hit.t == self.t && primitive < self.primitive) {
            *self = Self { t: hit.t, u: hit.u, v: hit.v, primitive };
        }
    }

    #[inline(always)]
    pub(super) fn is_hit(&self) -> bool {
        self.primitive != NO_HIT
    }
}

/// Corner `k` of triangle `i` of a chunk: the place of its vertex.
#[inline(always)]
pub(super) fn corners_of(words: &[u32], chunk: Chunk, i: usize) -> [usize; 3] {
    let corners = words[chunk.corners_at() + i / 2] >> (16 * (i % 2));
    [0, 1, 2].map(|k| (corners >> (5 * k) & 31) as usize)
}

/// Triangle `i` of a chunk.
#[inline(always)]
pub(super) fn triangle_at(words: &[u32], chunk: Chunk, i: usize) -> Triangle {
    let vertices = chunk.vertices();
    let x = |at: usize| f32::from_bits(words[at]);
    corners_of(words, chunk, i).map(|v| Vec3::new(x(v), x(vertices + v), x(2 * vertices + v)))
}

/// Tests a chunk's triangles one after the other.
pub(super) fn test_triangles(words: &[u32], chunk: Chunk, ray: &ShearedRay, best: &mut Best) {
    for i in 0..chunk.triangles() {
        if let Some(hit) = triangle::intersect(ray, &triangle_at(words, chunk, i), best.t.next_up())
        {
            best.offer(hit, words[chunk.ids_at() + i]);
        }
    }
}
