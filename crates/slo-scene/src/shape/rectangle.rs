//! `rectangle`

use glam::DVec3;

use super::corners::{CORNERS, corners};
use super::surface::{Surface, WrittenShape};
use crate::assets::Assets;
use crate::attributes::Fields;
use crate::kinds::Keyword;
use crate::light_map::Unwrapped;

/// A rectangle by three consecutive corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// Corners; the fourth is `v0 + v2 - v1`.
    pub vertices: [DVec3; 3],
}

impl WrittenShape for Rectangle {
    const KEYWORDS: &'static [Keyword] = &[Keyword { keyword: "rectangle", attributes: &CORNERS }];

    fn read(fields: &mut Fields<'_, '_, '_>, _: &mut Assets<'_>) -> Option<Self> {
        Self::of_corners(fields)
    }
}

impl Rectangle {
    /// Reads the attributes [`CORNERS`] of an element.
    pub(crate) fn of_corners(fields: &mut Fields<'_, '_, '_>) -> Option<Self> {
        Some(Self { vertices: corners(fields, true)? })
    }

    /// All four corners in order.
    pub fn corners(&self) -> [DVec3; 4] {
        let [a, b, c] = self.vertices;
        [a, b, c, a + c - b]
    }
}

impl Surface for Rectangle {
    fn triangle_count(&self) -> usize {
        2
    }

    fn is_closed(&self) -> bool {
        false
    }

    fn unwrapped(&self) -> Result<Unwrapped, &'static str> {
        Ok(Unwrapped::rectangle())
    }

    fn for_flat_parts(&self, put: &mut dyn FnMut(&[DVec3]) -> bool) {
        put(&self.corners());
    }
}
