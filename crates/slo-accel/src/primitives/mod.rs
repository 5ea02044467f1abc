//! What structures are built over: triangles and curved surfaces, and how a ray meets them.

pub(crate) mod clip;
pub mod curved;
pub mod triangle;

pub use self::curved::Curved;
pub use self::triangle::Triangle;
use crate::math::Bounds;

/// The primitives of one space. A primitive's id is its index: triangles come first
/// (`0..triangles.len()`), curved surfaces follow.
#[derive(Clone, Debug, Default)]
pub struct Primitives {
    /// Ids from 0.
    pub triangles: Vec<Triangle>,
    /// Ids from `triangles.len()`.
    pub curved: Vec<Curved>,
}

impl Primitives {
    /// How many ids there are.
    pub fn len(&self) -> usize {
        self.triangles.len() + self.curved.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The smallest box about the primitive `id`, in f32 rounded outward.
    pub fn bounds(&self, id: u32) -> Bounds {
        let id = id as usize;
        match self.triangles.get(id) {
            Some(triangle) => Bounds::of_points(*triangle),
            None => self.curved[id - self.triangles.len()].bounds(),
        }
    }

    /// The smallest box about all of them.
    pub fn all_bounds(&self) -> Bounds {
        (0..self.len() as u32).fold(Bounds::EMPTY, |b, id| b.union(self.bounds(id)))
    }

    /// Bytes of the primitives themselves.
    pub fn memory(&self) -> usize {
        size_of_val(self.triangles.as_slice()) + size_of_val(self.curved.as_slice())
    }
}
