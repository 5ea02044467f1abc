//! Leaves: how they are packed, and their test in plain Rust.

use glam::Vec3;

use super::build::Node;
use super::treelet::Child;
use crate::triangle::{self, ShearedRay, TriangleHit};
use crate::{LANES, Primitives, Triangle};

/// Up to 16 triangles of a leaf and what comes after them.
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

/// The contents of all leaves, one after the other, in words; each begins at a multiple of four.
#[derive(Debug, Default)]
pub(super) struct Arena {
    pub(super) words: Vec<u32>,
}

impl Arena {
    /// Appends the leaf of some primitives, ids ascending.
    pub(super) fn push_leaf(&mut self, primitives: &Primitives, ids: &[u32]) -> Node {
        let triangles = ids.partition_point(|&id| (id as usize) < primitives.triangles.len());
        let (mut flat, curved) = ids.split_at(triangles);
        let offset = self.words.len();
        loop {
            let packed = Packed::first_of(primitives, flat);
            flat = &flat[packed.ids.len()..];
            let more = !flat.is_empty();
            let chunk = Chunk::new(
                packed.ids.len(),
                packed.vertices.len(),
                !more && !curved.is_empty(),
                more,
            );
            self.words.push(chunk.0);
            packed.append_to(&mut self.words);
            if !more {
                break;
            }
        }
        if !curved.is_empty() {
            self.words.push(curved.len() as u32);
            self.words.extend_from_slice(curved);
        }
        self.words.resize(self.words.len().next_multiple_of(Child::UNIT), 0);
        Node::leaf(offset as u32, Chunk(self.words[offset]))
    }

    /// Appends another arena's words.
    pub(super) fn append(&mut self, mut other: Self) {
        self.words.append(&mut other.words);
    }

    /// Makes loads of whole registers safe to the last leaf.
    pub(super) fn finish(&mut self) {
        self.words.extend([0; 4 * LANES]);
        self.words.shrink_to_fit();
    }
}

/// The triangles of one chunk.
struct Packed<'a> {
    ids: &'a [u32],
    vertices: Vec<Vec3>,
    corners: [u16; Chunk::MAX_TRIANGLES],
}

impl<'a> Packed<'a> {
    /// As many of the first triangles as fit in a chunk.
    fn first_of(primitives: &Primitives, ids: &'a [u32]) -> Self {
        let mut packed = Self { ids: &[], vertices: Vec::with_capacity(32), corners: [0; 16] };
        for (i, &id) in ids.iter().take(Chunk::MAX_TRIANGLES).enumerate() {
            let known = packed.vertices.len();
            let corners = primitives.triangles[id as usize].map(|p| packed.vertex(p));
            if packed.vertices.len() > Chunk::MAX_VERTICES {
                packed.vertices.truncate(known);
                break;
            }
            packed.corners[i] = corners[0] | corners[1] << 5 | corners[2] << 10;
            packed.ids = &ids[..=i];
        }
        packed
    }

    /// Index of a vertex, added if it is new.
    fn vertex(&mut self, p: Vec3) -> u16 {
        let bits = |p: Vec3| p.to_array().map(f32::to_bits);
        let place = self.vertices.iter().position(|&q| bits(p) == bits(q));
        let place = place.unwrap_or_else(|| {
            self.vertices.push(p);
            self.vertices.len() - 1
        });
        place as u16
    }

    fn append_to(&self, words: &mut Vec<u32>) {
        for axis in 0..3 {
            words.extend(self.vertices.iter().map(|p| p[axis].to_bits()));
        }
        let corners = &self.corners[..self.ids.len().next_multiple_of(2)];
        words.extend(corners.chunks(2).map(|c| u32::from(c[0]) | u32::from(c[1]) << 16));
        words.extend_from_slice(self.ids);
    }
}

/// The nearest hit so far; `t` is the largest that still counts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Best {
    pub(super) t: f32,
    pub(super) u: f32,
    pub(super) v: f32,
    pub(super) primitive: u32,
}

impl Best {
    /// Nothing so far, of a ray whose hits up to `t` count.
    #[inline(always)]
    pub(super) fn up_to(t: f32) -> Self {
        Self { t, u: 0.0, v: 0.0, primitive: super::NO_HIT }
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
        self.primitive != super::NO_HIT
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
