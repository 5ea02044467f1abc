//! `lamp_disc`

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::lamp::{
    CAMERA_VISIBLE, LIGHT_GROUP, Lamp, MOTION, REPEAT, SOLID, WrittenLight, radiance_of,
};
use crate::attributes::schema::{color, number, point};
use crate::attributes::{Bound, Fields};
use crate::kinds::Keyword;
use crate::material::Palette;
use crate::shape::{Shape, axes_about};

/// Corners of the polygon that stands for the disc.
const CORNERS: u32 = 24;

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
            CAMERA_VISIBLE,
            SOLID,
            LIGHT_GROUP,
            MOTION,
            REPEAT,
        ],
    }];

    fn read<'a>(fields: &mut Fields<'_, 'a, '_>, _: &mut Palette<'_, 'a>) -> Option<Self> {
        let two_sided = fields.count("two_sided", 0, 1).is_some_and(|flag| flag.value == 1);
        let center = fields.point("center");
        let normal = fields.direction("normal");
        let radius = fields.length("radius", Bound::Positive);
        // Without a radius, the light itself is checked all the same.
        let area = radius.map_or(1.0, |radius| PI * radius.value * radius.value);
        let radiance = radiance_of(fields, if two_sided { 2.0 * area } else { area });
        let (center, normal) = (center?.value, normal?.value.normalize());
        Some(Self { radiance: radiance?, center, normal, radius: radius?.value, two_sided })
    }
}

impl Lamp for DiscLamp {
    fn is_dark(&self) -> bool {
        self.radiance == [0.0; 3]
    }

    /// A disc is no shape of the language.
    fn surface(&self) -> Option<Shape> {
        None
    }

    fn for_flat_parts(&self, put: &mut dyn FnMut(&[DVec3]) -> bool) {
        let [x, y] = axes_about(self.normal).map(|axis| axis * self.radius);
        let corner = |i| {
            let (sine, cosine) = libm::sincos(TAU * f64::from(i) / f64::from(CORNERS));
            self.center + x * cosine + y * sine
        };
        let corners: Vec<_> = (0..CORNERS).map(corner).collect();
        put(&corners);
    }
}
