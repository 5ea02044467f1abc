//! The surface of a `lamp_disc`.

use glam::swizzles::Vec3Swizzles as _;
use glam::{DVec3, Vec3};

use super::geometry::CurvedSurface;
use super::round::uv_about;
use crate::frame::sampled_motion::ObjectBox;
use slo_accel::Curved;
use slo_accel::curved::Part;
use slo_scene::animation::DAffine;
use slo_scene::light::DiscLamp;

impl CurvedSurface for DiscLamp {
    fn primitive(&self, place: &DAffine) -> Curved {
        let center = place.point(self.center).as_vec3();
        let normal = place.direction(self.normal).as_vec3();
        Curved::Disc { center, normal, radius: place.length(self.radius) as f32 }
    }

    fn bounds(&self) -> ObjectBox {
        let n = self.normal;
        let reach = DVec3::new(n.yz().length(), n.zx().length(), n.xy().length()) * self.radius;
        ObjectBox { min: self.center - reach, max: self.center + reach }
    }

    fn axis(&self) -> [DVec3; 2] {
        [self.center, self.normal]
    }

    fn uv_at(&self, point: Vec3, part: Part) -> [f32; 2] {
        uv_about(self.axis(), self.radius, point, part, |_, _| 0.0)
    }
}
