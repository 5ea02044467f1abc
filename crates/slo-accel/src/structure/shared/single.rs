//! The test of one primitive with one ray, for structures that trace rays one by one.

use glam::Vec3;

use crate::isa::Isa;
use crate::primitives::Primitives;
use crate::primitives::triangle::{self, ShearedRay, TriangleHit};

/// A ray for tests of primitives.
pub(crate) struct Single {
    origin: Vec3,
    direction: Vec3,
    sheared: ShearedRay,
    isa: Isa,
}

impl Single {
    pub(crate) fn new(origin: Vec3, direction: Vec3, isa: Isa) -> Self {
        Self { origin, direction, sheared: ShearedRay::new(origin, direction), isa }
    }

    /// The hit of a primitive with `0 < t < t_max`; of a curved surface, `u` is the part. Triangles
    /// must not be degenerate.
    pub(crate) fn test(&self, primitives: &Primitives, id: u32, t_max: f32) -> Option<TriangleHit> {
        let Some(triangle) = primitives.triangles.get(id as usize) else {
            let curved = &primitives.curved[id as usize - primitives.triangles.len()];
            let (t, part) = curved.intersect(self.origin, self.direction, t_max)?;
            return Some(TriangleHit { t, u: part.to_u(), v: 0.0 });
        };
        match self.isa {
            // SAFETY: the set is one that the CPU has.
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 | Isa::Avx512 => unsafe { intersect_by_fma(&self.sheared, triangle, t_max) },
            _ => triangle::intersect(&self.sheared, triangle, t_max),
        }
    }
}

/// The same bits as without the instruction, for which a library is called otherwise.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "fma")]
fn intersect_by_fma(
    ray: &ShearedRay,
    triangle: &crate::primitives::Triangle,
    t_max: f32,
) -> Option<TriangleHit> {
    triangle::intersect(ray, triangle, t_max)
}

/// Whether a primitive can be hit: it has an area, and a box.
pub(crate) fn can_be_hit(primitives: &Primitives, id: u32) -> bool {
    primitives.triangles.get(id as usize).is_none_or(|t| !triangle::is_degenerate(t))
        && !primitives.bounds(id).is_empty()
}
