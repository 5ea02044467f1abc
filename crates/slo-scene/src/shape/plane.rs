//! `plane`

use glam::DVec3;

use super::flat::axes_about;
use super::surface::{Surface, WrittenShape};
use crate::assets::Assets;
use crate::attributes::Fields;
use crate::attributes::schema::point;
use crate::kinds::Keyword;
use crate::light_map::Unwrapped;

/// Side of the square, before `Scaling`.
const SIDE: f64 = 1000.0;

/// A square about a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Not 0; need not be unit.
    pub normal: DVec3,
    /// Centre of the square.
    pub position: DVec3,
    /// 1000 times `Scaling`.
    pub side: f64,
}

impl WrittenShape for Plane {
    const KEYWORDS: &'static [Keyword] = &[Keyword {
        keyword: "plane",
        attributes: &[point("normal").required(), point("position").required()],
    }];

    fn read(fields: &mut Fields<'_, '_, '_>, _: &mut Assets<'_>) -> Option<Self> {
        let normal = fields.direction("normal");
        let position = fields.point("position");
        let side = SIDE * fields.scale;
        Some(Self { normal: normal?.value, position: position?.value, side })
    }
}

impl Surface for Plane {
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
        let normal = self.normal.normalize_or_zero();
        let [x, y] = axes_about(normal).map(|axis| axis * (0.5 * self.side));
        put(&[-x - y, x - y, x + y, y - x].map(|offset| self.position + offset));
    }
}
