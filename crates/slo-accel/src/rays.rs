//! Batches of rays and of hits, as structures of arrays.

/// Arrays of a batch are readable up to a multiple of this many elements (the widest SIMD
/// register), so that kernels need no masked loads.
pub const LANES: usize = 16;

/// Primitive id of a ray that hits nothing.
pub const NO_HIT: u32 = u32::MAX;

/// How alike neighbouring rays of a batch are: from what is expected a structure picks its kernel,
/// and tells what it found. It never changes an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coherence {
    /// Runs of 16 rays go similar ways: camera rays of a small patch of pixels, what mirrors and
    /// glass make of them, and shadow rays of neighbouring hits toward one light.
    Coherent,
    /// Neighbours have nothing in common: bounces of rough surfaces.
    Incoherent,
}

/// Rays in one space. Points of a ray are `origin + t direction`, `0 < t < t_max`; directions need
/// not be unit, and `t` counts in their lengths.
#[derive(Clone, Debug, Default)]
pub struct Rays {
    len: usize,
    /// x, y and z of the origins.
    pub origin: [Vec<f32>; 3],
    /// x, y and z of the directions; finite, not 0.
    pub direction: [Vec<f32>; 3],
    /// End of each ray; positive, may be infinite.
    pub t_max: Vec<f32>,
}

impl Rays {
    /// Room for `capacity` rays, none in it.
    pub fn with_capacity(capacity: usize) -> Self {
        let array = || vec![0.0; capacity.next_multiple_of(LANES)];
        Self {
            len: 0,
            origin: std::array::from_fn(|_| array()),
            direction: std::array::from_fn(|_| array()),
            t_max: array(),
        }
    }

    /// How many rays there are.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Makes the batch `len` rays long; the arrays keep what they hold, and new elements are 0.
    pub fn set_len(&mut self, len: usize) {
        self.len = len;
        let padded = len.next_multiple_of(LANES);
        if self.t_max.len() < padded {
            self.origin.iter_mut().chain(&mut self.direction).for_each(|a| a.resize(padded, 0.0));
            self.t_max.resize(padded, 0.0);
        }
    }

    /// Adds one ray at the end.
    pub fn push(&mut self, origin: glam::Vec3, direction: glam::Vec3, t_max: f32) {
        let i = self.len;
        self.set_len(i + 1);
        for axis in 0..3 {
            self.origin[axis][i] = origin[axis];
            self.direction[axis][i] = direction[axis];
        }
        self.t_max[i] = t_max;
    }

    /// Moves the rays from `start` on to the front of `other`, which then holds no others.
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
    pub fn origin(&self, i: usize) -> glam::Vec3 {
        glam::Vec3::new(self.origin[0][i], self.origin[1][i], self.origin[2][i])
    }

    /// Direction of ray `i`.
    pub fn direction(&self, i: usize) -> glam::Vec3 {
        glam::Vec3::new(self.direction[0][i], self.direction[1][i], self.direction[2][i])
    }
}

/// The first hit of each ray of a batch.
#[derive(Clone, Debug, Default)]
pub struct Hits {
    /// Distance in lengths of the direction; infinite where nothing is hit.
    pub t: Vec<f32>,
    /// Triangles: weight of the second corner. Curved surfaces: 0 the side, 1 the disc at `base`,
    /// 2 the disc at `top`.
    pub u: Vec<f32>,
    /// Triangles: weight of the third corner.
    pub v: Vec<f32>,
    /// Primitive id, [`NO_HIT`] where nothing is hit.
    pub primitive: Vec<u32>,
}

impl Hits {
    /// Forgets everything and makes room for `len` hits, all of nothing.
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
