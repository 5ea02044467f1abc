//! `sphere`

use glam::DVec3;

use super::surface::{Surface, WrittenShape};
use crate::assets::Assets;
use crate::attributes::schema::{number, point};
use crate::attributes::{Bound, Fields};
use crate::kinds::Keyword;
use crate::light_map::Unwrapped;

/// A sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre.
    pub center: DVec3,
    /// More than 0.
    pub radius: f64,
}

impl WrittenShape for Sphere {
    const KEYWORDS: &'static [Keyword] = &[Keyword {
        keyword: "sphere",
        attributes: &[point("center").required(), number("radius").required()],
    }];

    fn read(fields: &mut Fields<'_, '_, '_>, _: &mut Assets<'_>) -> Option<Self> {
        let center = fields.point("center");
        let radius = fields.length("radius", Bound::Positive);
        Some(Self { center: center?.value, radius: radius?.value })
    }
}

impl Surface for Sphere {
    fn triangle_count(&self) -> usize {
        0
    }

    fn is_closed(&self) -> bool {
        true
    }

    fn unwrapped(&self) -> Result<Unwrapped, &'static str> {
        Ok(Unwrapped::Sphere)
    }

    fn for_flat_parts(&self, _put: &mut dyn FnMut(&[DVec3]) -> bool) {}
}
