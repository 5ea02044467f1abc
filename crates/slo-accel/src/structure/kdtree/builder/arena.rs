//! The contents of leaves while the tree grows.

use glam::Vec3;

use super::node::Node;
use crate::primitives::Primitives;
use crate::rays::LANES;
use crate::structure::kdtree::leaf::Chunk;
use crate::structure::kdtree::treelet::Child;

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
