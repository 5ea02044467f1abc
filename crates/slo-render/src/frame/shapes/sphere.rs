//! `sphere`

use glam::{DVec3, Vec3};

use super::geometry::CurvedSurface;
use super::round::{about_balls, uv_about};
use crate::frame::sampled_motion::ObjectBox;
use slo_accel::Curved;
use slo_accel::curved::Part;
use slo_scene::animation::DAffine;
use slo_scene::shape::Sphere;

impl CurvedSurface for Sphere {
    fn primitive(&self, place: &DAffine) -> Curved {
        let center = place.point(self.center).as_vec3();
        Curved::Sphere { center, radius: place.length(self.radius) as f32 }
    }

    fn bounds(&self) -> ObjectBox {
        about_balls(&[self.center], self.radius)
    }

    fn axis(&self) -> [DVec3; 2] {
        [self.center, DVec3::Z]
    }

    fn uv_at(&self, point: Vec3, part: Part) -> [f32; 2] {
        uv_about(self.axis(), self.radius, point, part, |along, _| {
            0.5 + libm::asin((along / self.radius).clamp(-1.0, 1.0)) / std::f64::consts::PI
        })
    }
}
