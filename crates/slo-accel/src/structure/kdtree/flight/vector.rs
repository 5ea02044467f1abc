//! Operations of the stream beyond arithmetic, for one instruction set.

use super::entries::Entries;
use super::ray::Ray;
use crate::simd::{Quads, SetLanes};
use crate::structure::kdtree::leaf::Chunk;
use crate::structure::kdtree::treelet::Treelet;
use crate::structure::shared::order::Choosing;

/// A ray in all lanes, in the sheared axes.
#[derive(Clone, Copy)]
pub(crate) struct ShearedLanes<V> {
    pub(crate) axes: [usize; 3],
    pub(crate) origin: [V; 3],
    pub(crate) shear: [V; 3],
}

/// A register of triangles or of rays.
///
/// # Safety
/// As [`Lanes`](crate::simd::Lanes); functions on sets of bits also need BMI and POPCNT.
pub(crate) trait Vector: Quads + SetLanes {
    /// How rays are chosen.
    type Choosing: Choosing;

    /// Writes the children of a treelet that a ray visits within a span, from far to near, each
    /// with its own span; only those in `among`, bit `c` for child `c`. Returns their number. Eight
    /// entries may be overwritten.
    unsafe fn children(
        treelet: &Treelet,
        ray: &Ray,
        span: [f32; 2],
        among: u8,
        to: Entries,
    ) -> usize;

    /// Drops the entries of a stack of `len` that begin behind `t`, and ends the others there;
    /// returns the number of entries kept. Eight entries beyond the last may be overwritten.
    unsafe fn cull(stack: Entries, len: usize, t: f32) -> usize;

    /// The least of all lanes, in all of them.
    unsafe fn least(self) -> Self;

    /// The least of each four lanes, in all four of them.
    unsafe fn least_of_quads(self) -> Self;

    /// Sheared corners (by corner, then x, y, and z of the sheared axes) of up to a register of
    /// triangles of a chunk, from the `first` triangle on, which is a multiple of their number;
    /// origin and shear are those of the ray. Lanes that are not `present` hold no triangle, and
    /// numbers computed from some vertex: other words, taken for numbers, may be subnormal, which
    /// is many times slower on some CPUs.
    ///
    /// The words are those of a chunk of a finished arena.
    unsafe fn sheared_corners(
        words: *const u32,
        chunk: Chunk,
        ray: ShearedLanes<Self>,
        first: usize,
        present: u32,
    ) -> [[Self; 3]; 3];

    /// Corners, not sheared, of `M` chunks that fit in a quarter of 16 lanes each, as many as a
    /// register has quads; lanes that are not present as above.
    unsafe fn corners_of_quads<const M: usize>(
        words: [*const u32; M],
        chunks: [Chunk; M],
        axes: [[usize; 3]; M],
        present: u32,
    ) -> [[Self; 3]; 3];
}
