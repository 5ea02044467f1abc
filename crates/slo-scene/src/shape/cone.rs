//! `cone`

use glam::DVec3;

use super::axis::axis;
use super::flat::disc;
use super::surface::{Surface, WrittenShape};
use crate::assets::Assets;
use crate::attributes::schema::{number, point};
use crate::attributes::{Bound, Fields};
use crate::kinds::Keyword;
use crate::light_map::Unwrapped;

/// A cone, closed by a disc at its base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Centre of the disc.
    pub base: DVec3,
    /// Tip.
    pub apex: DVec3,
    /// Radius of the disc; more than 0.
    pub radius: f64,
}

impl WrittenShape for Cone {
    const KEYWORDS: &'static [Keyword] = &[Keyword {
        keyword: "cone",
        attributes: &[
            point("base").required(),
            point("apex").required(),
            number("radius").required(),
        ],
    }];

    fn read(fields: &mut Fields<'_, '_, '_>, _: &mut Assets<'_>) -> Option<Self> {
        let [base, apex] = axis(fields, "base", "apex")?;
        let radius = fields.length("radius", Bound::Positive)?.value;
        Some(Self { base, apex, radius })
    }
}

impl Surface for Cone {
    fn triangle_count(&self) -> usize {
        0
    }

    fn is_closed(&self) -> bool {
        true
    }

    fn unwrapped(&self) -> Result<Unwrapped, &'static str> {
        Err("the side and the end of a cone have the same texture coordinates")
    }

    fn for_flat_parts(&self, put: &mut dyn FnMut(&[DVec3]) -> bool) {
        put(&disc(self.base, self.base - self.apex, self.radius));
    }
}
