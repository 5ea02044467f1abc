//! `box`

use glam::DVec3;

use super::corners::corners;
use super::rectangle::Rectangle;
use super::surface::{Surface, WrittenShape};
use crate::assets::Assets;
use crate::attributes::schema::{number, point};
use crate::attributes::{Bound, Fields};
use crate::kinds::Keyword;
use crate::light_map::Unwrapped;

/// A base rectangle, raised along (v2 - v1) x (v0 - v1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cuboid {
    /// Three consecutive corners of the base.
    pub vertices: [DVec3; 3],
    /// Not 0.
    pub height: f64,
}

impl WrittenShape for Cuboid {
    const KEYWORDS: &'static [Keyword] = &[Keyword {
        keyword: "box",
        attributes: &[
            point("vertex0").required(),
            point("vertex1").required(),
            point("vertex2").required(),
            number("height").required(),
        ],
    }];

    fn read(fields: &mut Fields<'_, '_, '_>, _: &mut Assets<'_>) -> Option<Self> {
        let vertices = corners(fields, true);
        let height = fields.length("height", Bound::NotZero);
        Some(Self { vertices: vertices?, height: height?.value })
    }
}

impl Surface for Cuboid {
    fn triangle_count(&self) -> usize {
        12
    }

    fn is_closed(&self) -> bool {
        true
    }

    fn unwrapped(&self) -> Result<Unwrapped, &'static str> {
        Err("the six sides of a box have the same texture coordinates")
    }

    fn for_flat_parts(&self, put: &mut dyn FnMut(&[DVec3]) -> bool) {
        let [a, b, c, d] = Rectangle { vertices: self.vertices }.corners();
        let up = (c - b).cross(a - b).normalize_or_zero() * self.height;
        let sides = [[a, b], [b, c], [c, d], [d, a]];
        // The base is counter-clockwise seen from above if the box rises.
        let faces = sides.map(|[p, q]| [p, q, q + up, p + up]);
        let caps = [[d, c, b, a], [a + up, b + up, c + up, d + up]];
        for mut face in faces.into_iter().chain(caps) {
            if self.height < 0.0 {
                face.reverse();
            }
            if !put(&face) {
                return;
            }
        }
    }
}
