//! `triangle`

use glam::DVec3;

use super::corners::{CORNERS, corners};
use super::surface::{Surface, WrittenShape};
use crate::assets::Assets;
use crate::attributes::Fields;
use crate::kinds::Keyword;
use crate::light_map::Unwrapped;

/// A triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// Corners.
    pub vertices: [DVec3; 3],
}

impl WrittenShape for Triangle {
    const KEYWORDS: &'static [Keyword] = &[Keyword { keyword: "triangle", attributes: &CORNERS }];

    fn read(fields: &mut Fields<'_, '_, '_>, _: &mut Assets<'_>) -> Option<Self> {
        Some(Self { vertices: corners(fields, false)? })
    }
}

impl Surface for Triangle {
    fn triangle_count(&self) -> usize {
        1
    }

    fn is_closed(&self) -> bool {
        false
    }

    fn unwrapped(&self) -> Result<Unwrapped, &'static str> {
        Ok(Unwrapped::Faces(vec![[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]]))
    }

    fn for_flat_parts(&self, put: &mut dyn FnMut(&[DVec3]) -> bool) {
        put(&self.vertices);
    }
}
