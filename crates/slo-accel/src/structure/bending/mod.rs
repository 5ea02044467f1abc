//! Triangles that bend: their corners move straight and evenly from shape to shape, and each ray
//! meets them as they are at its own time.
//!
//! Between two shapes lies a piece of the time, with a hierarchy of its own. It is the one of
//! [`bvh`](super::bvh), with boxes and corners that move: a node has its boxes at the start of the
//! piece, and how far their planes move until its end.

#[cfg(test)]
mod tests;

use super::Scratch;
use super::bvh::Bvh;
use super::interface::{Geometry, SpatialIndex};
use crate::isa::Isa;
use crate::math::Bounds;
use crate::primitives::Triangle;
use crate::rays::{Coherence, Hits, LANES, Rays};

/// Triangles whose corners move, with a structure that finds those on a ray at the ray's time.
///
/// ```
/// use slo_accel::glam::Vec3;
/// use slo_accel::{Bending, Coherence, Hits, Isa, NO_HIT, Rays, Scratch};
///
/// let low = vec![[Vec3::ZERO, Vec3::X, Vec3::Y]];
/// let high = vec![[Vec3::Z, Vec3::X + Vec3::Z, Vec3::Y + Vec3::Z]];
/// let bending = Bending::build(&[low, high], &[0.0, 1.0], Isa::best());
/// let mut rays = Rays::with_capacity(2);
/// for _ in 0..2 {
///     rays.push(Vec3::new(0.25, 0.5, 2.0), Vec3::NEG_Z, f32::INFINITY);
/// }
/// let (mut hits, mut scratch) = (Hits::default(), Scratch::default());
/// bending.intersect(&rays, &[0.0, 0.5], Coherence::Coherent, &mut hits, &mut scratch);
/// assert_eq!(hits.t[..2], [2.0, 1.5]);
/// assert_eq!(bending.triangle(0, 0.5)[0], Vec3::new(0.0, 0.0, 0.5));
/// ```
///
/// A corner that moves from `a` to `b` is at `a + (b - a) * u` at the moment `u` of its piece, each
/// operation rounded to f32: the same bits for every triangle that shares the corner. Hits are those
/// of the triangles at the ray's time, as a [`Structure`](super::Structure) over them gives them, but
/// for triangles that have no area at just that time: they are tested as all others.
#[derive(Debug)]
pub struct Bending {
    /// Times of the shapes, ascending.
    times: Vec<f32>,
    /// One for each two shapes.
    pieces: Vec<Bvh>,
}

/// A time, by the piece in which it lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Number of the shape from which the triangles move; they move to the next one.
    pub shape: usize,
    /// How much of the way is covered, from 0 to 1.
    pub part: f32,
}

/// Working memory of queries: the rays of one piece.
#[derive(Debug, Default)]
pub(super) struct OfPiece {
    rays: Rays,
    times: Vec<f32>,
    /// Indices in the batch.
    indices: Vec<u32>,
    hits: Hits,
    blocked: Vec<bool>,
}

impl Bending {
    /// Builds a structure over triangles that move from shape to shape, on all threads of the
    /// current rayon pool. The same shapes give the same structure for any number of threads.
    ///
    /// `times` are those of the shapes, ascending. Before the first time the triangles are at rest,
    /// and after the last.
    /// Triangles without area in two neighbouring shapes and halfway between them, and triangles
    /// with coordinates that are not finite, are never hit from one to the other.
    ///
    /// # Panics
    /// If there are fewer than two shapes, if the shapes have different numbers of triangles or
    /// more than [`MAX_PRIMITIVES`](super::Structure::MAX_PRIMITIVES), if there is not one time for
    /// each shape, or if times do not ascend.
    pub fn build(shapes: &[Vec<Triangle>], times: &[f32], isa: Isa) -> Self {
        Self::build_from(None, shapes, times, isa)
    }

    /// The same, but starts from a structure over the same triangles in other shapes, such as those
    /// of the frame before. Where rays cost at most `most_growth` times as much as in the hierarchy
    /// that was built, as [`Structure::refitted`](super::Structure::refitted) has it, the hierarchy
    /// stays, which takes a fraction of the time. Hits are the same.
    ///
    /// # Panics
    /// In the same cases as [`build`](Self::build).
    pub fn build_like(
        before: &Self,
        most_growth: f64,
        shapes: &[Vec<Triangle>],
        times: &[f32],
        isa: Isa,
    ) -> Self {
        Self::build_from(Some((before, most_growth)), shapes, times, isa)
    }

    fn build_from(
        before: Option<(&Self, f64)>,
        shapes: &[Vec<Triangle>],
        times: &[f32],
        isa: Isa,
    ) -> Self {
        assert!(shapes.len() >= 2, "two shapes or more");
        assert_eq!(shapes.len(), times.len(), "a time for each shape");
        assert!(times.windows(2).all(|pair| pair[0] < pair[1]), "times ascend");
        let count = shapes[0].len();
        assert!(
            shapes.iter().all(|shape| shape.len() == count),
            "the same triangles in each shape"
        );
        assert!(count <= super::Structure::MAX_PRIMITIVES, "at most 2^28 triangles");
        let mut pieces: Vec<Bvh> = Vec::with_capacity(shapes.len() - 1);
        for pair in shapes.windows(2) {
            let [starts, ends] = [&pair[0], &pair[1]];
            let fitted = before.and_then(|(before, most_growth)| {
                let nearest = pieces.last().or(before.pieces.last())?;
                nearest.refitted_moving(starts, ends, most_growth, isa)
            });
            pieces.push(fitted.unwrap_or_else(|| Bvh::build_moving(starts, ends, isa)));
        }
        Self { times: times.to_vec(), pieces }
    }

    /// Number of triangles.
    #[inline]
    pub fn triangle_count(&self) -> usize {
        self.pieces[0].triangle_count()
    }

    /// The piece in which a time lies.
    #[inline]
    pub fn moment(&self, time: f32) -> Moment {
        let inner = &self.times[1..self.times.len() - 1];
        let shape = inner.iter().take_while(|&&start| start <= time).count();
        let (start, end) = (self.times[shape], self.times[shape + 1]);
        let part = (time - start) / (end - start);
        // NaN becomes 0.
        Moment { shape, part: if part > 0.0 { part.min(1.0) } else { 0.0 } }
    }

    /// The triangle of an id at a time.
    ///
    /// # Panics
    /// If `id` is not below [`triangle_count`](Self::triangle_count).
    #[inline]
    pub fn triangle(&self, id: u32, time: f32) -> Triangle {
        let Moment { shape, part } = self.moment(time);
        self.pieces[shape].triangle_at(id, part)
    }

    /// A box about the triangles that can be hit, at all times.
    pub fn bounds(&self) -> Bounds {
        self.pieces.iter().fold(Bounds::EMPTY, |all, piece| all.union(piece.all_bounds()))
    }

    /// Bytes held: the shapes and everything built over them.
    pub fn memory(&self) -> usize {
        self.pieces.iter().map(|piece| piece.memory() + piece.overhead()).sum()
    }

    /// Writes the first hit of each ray with `0 < t < t_max`, at the ray's time, to
    /// `hits[0..rays.len()]`; what `hits` held before is dropped. `coherence` and what comes back
    /// are as for [`Structure::intersect`](super::Structure::intersect).
    ///
    /// # Panics
    /// If there are fewer times than rays.
    pub fn intersect(
        &self,
        rays: &Rays,
        times: &[f32],
        coherence: Coherence,
        hits: &mut Hits,
        scratch: &mut Scratch,
    ) -> Coherence {
        hits.reset(rays.len());
        let Scratch { bvh, of_piece, .. } = scratch;
        if self.is_plain() {
            return self.pieces[0].intersect_at((rays, times), coherence, hits, bvh);
        }
        self.for_each_piece((rays, times), coherence, of_piece, |piece, of_piece| {
            let OfPiece { rays, times, indices, hits: found, .. } = of_piece;
            found.reset(rays.len());
            let coherence = piece.intersect_at((rays, times), coherence, found, bvh);
            for (from, &to) in indices.iter().enumerate() {
                let to = to as usize;
                hits.t[to] = found.t[from];
                hits.u[to] = found.u[from];
                hits.v[to] = found.v[from];
                hits.primitive[to] = found.primitive[from];
            }
            coherence
        })
    }

    /// Writes to `blocked[0..rays.len()]` whether anything lies on each ray with `0 < t < t_max` at
    /// the ray's time; what `blocked` held before is dropped. `coherence` and what comes back are as
    /// for [`Structure::intersect`](super::Structure::intersect).
    ///
    /// # Panics
    /// If there are fewer times than rays.
    pub fn occluded(
        &self,
        rays: &Rays,
        times: &[f32],
        coherence: Coherence,
        blocked: &mut Vec<bool>,
        scratch: &mut Scratch,
    ) -> Coherence {
        blocked.clear();
        blocked.resize(rays.len().next_multiple_of(LANES), false);
        let Scratch { bvh, of_piece, .. } = scratch;
        if self.is_plain() {
            return self.pieces[0].occluded_at((rays, times), coherence, blocked, bvh);
        }
        self.for_each_piece((rays, times), coherence, of_piece, |piece, of_piece| {
            let OfPiece { rays, times, indices, blocked: found, .. } = of_piece;
            found.clear();
            found.resize(rays.len().next_multiple_of(LANES), false);
            let coherence = piece.occluded_at((rays, times), coherence, found, bvh);
            for (&found, &to) in found.iter().zip(&*indices) {
                blocked[to as usize] = found;
            }
            coherence
        })
    }

    /// Whether the time of a ray is its part of the way.
    fn is_plain(&self) -> bool {
        self.times == [0.0, 1.0]
    }

    /// Asks each piece about the rays whose time lies in it. What comes back is coherent if all
    /// answers are.
    fn for_each_piece(
        &self,
        (rays, times): (&Rays, &[f32]),
        coherence: Coherence,
        of_piece: &mut OfPiece,
        mut ask: impl FnMut(&Bvh, &mut OfPiece) -> Coherence,
    ) -> Coherence {
        assert!(rays.len() <= times.len(), "a time for each ray");
        let mut all = coherence;
        for (shape, piece) in self.pieces.iter().enumerate() {
            of_piece.rays.set_len(0);
            of_piece.times.clear();
            of_piece.indices.clear();
            for (i, &time) in times.iter().enumerate().take(rays.len()) {
                let moment = self.moment(time);
                if moment.shape == shape {
                    of_piece.rays.push(rays.origin(i), rays.direction(i), rays.t_max[i]);
                    of_piece.times.push(moment.part);
                    of_piece.indices.push(i as u32);
                }
            }
            if !of_piece.indices.is_empty() && ask(piece, of_piece) == Coherence::Incoherent {
                all = Coherence::Incoherent;
            }
        }
        all
    }
}
