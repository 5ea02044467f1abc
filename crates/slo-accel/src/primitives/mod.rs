//! What structures are built over: triangles and curved surfaces, and how a ray meets them.

pub(crate) mod clip;
pub mod curved;
pub mod triangle;

pub use self::curved::Curved;
pub use self::triangle::Triangle;
use crate::math::Bounds;

/// The primitives of one space. The id of a triangle is its index; the ids of curved surfaces
/// follow those of the triangles.
///
/// A `Vec` of triangles becomes primitives by `into`. With curved surfaces:
///
/// ```
/// use slo_accel::{Curved, Primitives, glam::Vec3};
///
/// let mut primitives = Primitives::default();
/// primitives.curved.push(Curved::Sphere { center: Vec3::ZERO, radius: 0.5 });
/// assert_eq!(primitives.bounds(0).max, Vec3::splat(0.5));
/// ```
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Primitives {
    /// Triangles, ids from 0.
    pub triangles: Vec<Triangle>,
    /// Curved surfaces, ids from `triangles.len()`.
    pub curved: Vec<Curved>,
}

impl Primitives {
    /// Number of primitives.
    pub fn len(&self) -> usize {
        self.triangles.len() + self.curved.len()
    }

    /// Whether there are no primitives.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The smallest box about a primitive, rounded outward to f32.
    ///
    /// # Panics
    /// If `id` is not below [`len`](Self::len).
    pub fn bounds(&self, id: u32) -> Bounds {
        let id = id as usize;
        match self.triangles.get(id) {
            Some(triangle) => Bounds::of_points(*triangle),
            None => self.curved[id - self.triangles.len()].bounds(),
        }
    }

    /// The smallest box about all primitives; empty if there are none.
    pub fn all_bounds(&self) -> Bounds {
        (0..self.len() as u32).fold(Bounds::EMPTY, |b, id| b.union(self.bounds(id)))
    }

    /// Bytes that the primitives take.
    pub fn memory(&self) -> usize {
        size_of_val(self.triangles.as_slice()) + size_of_val(self.curved.as_slice())
    }
}

impl From<Vec<Triangle>> for Primitives {
    fn from(triangles: Vec<Triangle>) -> Self {
        Self { triangles, curved: vec![] }
    }
}
