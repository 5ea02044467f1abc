//! `lamp_disc`

use glam::DVec3;

use super::lamp::{Lamp, WrittenLight, radiance_of};
use crate::attributes::schema::{color, number, point};
use crate::attributes::{Bound, Fields};
use crate::kinds::Keyword;
use crate::material::Palette;
use crate::shape::Shape;

/// A disc that glows evenly in all directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiscLamp {
    /// W/(m² sr)
    pub radiance: [f32; 3],
    /// Centre.
    pub center: DVec3,
    /// Unit normal of the front.
    pub normal: DVec3,
    /// More than 0.
    pub radius: f64,
    /// Whether the back glows too.
    pub two_sided: bool,
}

impl WrittenLight for DiscLamp {
    const KEYWORDS: &'static [Keyword] = &[Keyword {
        keyword: "lamp_disc",
        attributes: &[
            color("power"),
            color("radiance"),
            point("center").required(),
            point("normal").required(),
            number("radius").required(),
            number("two_sided"),
        ],
    }];

    fn read<'a>(fields: &mut Fields<'_, 'a, '_>, _: &mut Palette<'_, 'a>) -> Option<Self> {
        let two_sided = fields.count("two_sided", 0, 1).is_some_and(|flag| flag.value == 1);
        let center = fields.point("center");
        let normal = fields.direction("normal");
        let radius = fields.length("radius", Bound::Positive);
        let (center, normal) = (center?.value, normal?.value.normalize());
        let radius = radius?.value;
        let area = std::f64::consts::PI * radius * radius;
        let radiance = radiance_of(fields, if two_sided { 2.0 * area } else { area })?;
        Some(Self { radiance, center, normal, radius, two_sided })
    }
}

impl Lamp for DiscLamp {
    fn is_dark(&self) -> bool {
        self.radiance == [0.0; 3]
    }

    /// A disc is no shape of the language yet.
    fn surface(&self) -> Option<Shape> {
        None
    }
}
