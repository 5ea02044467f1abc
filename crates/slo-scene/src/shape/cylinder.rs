//! `cylinder`

use glam::DVec3;

use super::axis::axis;
use super::flat::disc;
use super::surface::{Surface, WrittenShape};
use crate::assets::Assets;
use crate::attributes::schema::{number, point};
use crate::attributes::{Bound, Fields};
use crate::kinds::Keyword;
use crate::light_map::Unwrapped;

/// A closed cylinder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    /// Centre of one end.
    pub base: DVec3,
    /// Centre of the other end.
    pub top: DVec3,
    /// More than 0.
    pub radius: f64,
}

impl WrittenShape for Cylinder {
    const KEYWORDS: &'static [Keyword] = &[Keyword {
        keyword: "cylinder",
        attributes: &[
            point("base").required(),
            point("top").required(),
            number("radius").required(),
        ],
    }];

    fn read(fields: &mut Fields<'_, '_, '_>, _: &mut Assets<'_>) -> Option<Self> {
        let [base, top] = axis(fields, "base", "top")?;
        let radius = fields.length("radius", Bound::Positive)?.value;
        Some(Self { base, top, radius })
    }
}

impl Surface for Cylinder {
    fn triangle_count(&self) -> usize {
        0
    }

    fn is_closed(&self) -> bool {
        true
    }

    fn unwrapped(&self) -> Result<Unwrapped, &'static str> {
        Err("the side and the ends of a cylinder have the same texture coordinates")
    }

    fn for_flat_parts(&self, put: &mut dyn FnMut(&[DVec3]) -> bool) {
        let Self { base, top, radius } = *self;
        if put(&disc(base, base - top, radius)) {
            put(&disc(top, top - base, radius));
        }
    }
}
