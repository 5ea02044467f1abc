//! Batches of rays and of hits, as structures of arrays.

/// Lanes of the widest SIMD register. Arrays of a batch have a multiple of this many elements, so
/// that kernels need no masked loads.
pub const LANES: usize = 16;

/// Primitive id of a ray that hits nothing.
pub const NO_HIT: u32 = u32::MAX;

/// How alike neighbouring rays of a batch are. A structure chooses a kernel by what the caller
/// expects, and returns what it found. Answers never depend on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Coherence {
    /// Runs of 16 rays take similar ways: camera rays of a small patch of pixels, their reflections
    /// in mirrors and glass, and shadow rays from neighbouring hits to one light.
    Coherent,
    /// Neighbours have nothing in common: bounces of rough surfaces.
    Incoherent,
}

/// A batch of rays in one space, as a structure of arrays. A ray is the points
/// `origin + t direction` with `0 < t < t_max`. Directions may have any length; `t` counts in
/// lengths of the direction.
///
/// Each array has at least [`len`](Self::len) elements, rounded up to a multiple of [`LANES`];
/// elements behind the last ray mean nothing. A shorter array makes queries panic.
#[derive(Clone, Debug, Default)]
pub struct Rays {
    len: usize,
    /// x, y and z of the origins; finite.
    pub origin: [Vec<f32>; 3],
    /// x, y and z of the directions; finite, not 0.
    pub direction: [Vec<f32>; 3],
    /// End of each ray in lengths of its direction; may be infinite, but not NaN. A ray whose
    /// end is not above 0 hits nothing.
    pub t_max: Vec<f32>,
}

impl Rays {
    /// An empty batch with room for `capacity` rays.
    pub fn with_capacity(capacity: usize) -> Self {
        let array = || vec![0.0; capacity.next_multiple_of(LANES)];
        Self {
            len: 0,
            origin: std::array::from_fn(|_| array()),
            direction: std::array::from_fn(|_| array()),
            t_max: array(),
        }
    }

    /// Number of rays.
    #[inline]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether the batch has no rays.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Makes the batch `len` rays long. Elements keep their values; those of new ones are 0, or
    /// left over from longer batches.
    #[inline]
    pub fn set_len(&mut self, len: usize) {
        self.len = len;
        let padded = len.next_multiple_of(LANES);
        if self.t_max.len() < padded {
            self.origin.iter_mut().chain(&mut self.direction).for_each(|a| a.resize(padded, 0.0));
            self.t_max.resize(padded, 0.0);
        }
    }

    /// Adds one ray at the end.
    #[inline]
    pub fn push(&mut self, origin: glam::Vec3, direction: glam::Vec3, t_max: f32) {
        let i = self.len;
        self.set_len(i + 1);
        for axis in 0..3 {
            self.origin[axis][i] = origin[axis];
            self.direction[axis][i] = direction[axis];
        }
        self.t_max[i] = t_max;
    }

    /// Moves the rays from `start` on to `other`, and drops what that held before.
    ///
    /// # Panics
    /// If `start` is beyond the last ray.
    pub fn split_off_into(&mut self, start: usize, other: &mut Self) {
        let len = self.len - start;
        other.set_len(len);
        for axis in 0..3 {
            other.origin[axis][..len].copy_from_slice(&self.origin[axis][start..self.len]);
            other.direction[axis][..len].copy_from_slice(&self.direction[axis][start..self.len]);
        }
        other.t_max[..len].copy_from_slice(&self.t_max[start..self.len]);
        self.len = start;
    }

    /// Origin of ray `i`.
    #[inline]
    pub fn origin(&self, i: usize) -> glam::Vec3 {
        glam::Vec3::new(self.origin[0][i], self.origin[1][i], self.origin[2][i])
    }

    /// Direction of ray `i`.
    #[inline]
    pub fn direction(&self, i: usize) -> glam::Vec3 {
        glam::Vec3::new(self.direction[0][i], self.direction[1][i], self.direction[2][i])
    }
}

/// The first hit of each ray of a batch, as a structure of arrays: element `i` belongs to ray `i`.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Hits {
    /// Distance in lengths of the direction; infinite if nothing is hit.
    pub t: Vec<f32>,
    /// Triangles: weight of the second corner, from 0 to 1. Curved surfaces: the
    /// [`Part`](crate::curved::Part) that is hit.
    pub u: Vec<f32>,
    /// Triangles: weight of the third corner, from 0 to 1. Curved surfaces: 0.
    pub v: Vec<f32>,
    /// Id of the primitive; [`NO_HIT`] if nothing is hit.
    pub primitive: Vec<u32>,
}

impl Hits {
    /// Makes the arrays as long as a batch of `len` rays needs, all of which hit nothing.
    pub fn reset(&mut self, len: usize) {
        let padded = len.next_multiple_of(LANES);
        for array in [&mut self.t, &mut self.u, &mut self.v] {
            array.clear();
        }
        self.t.resize(padded, f32::INFINITY);
        self.u.resize(padded, 0.0);
        self.v.resize(padded, 0.0);
        self.primitive.clear();
        self.primitive.resize(padded, NO_HIT);
    }
}
