//! `cone`

use glam::{DVec3, Vec3};

use super::geometry::CurvedSurface;
use super::round::{about_balls, uv_about};
use crate::frame::sampled_motion::ObjectBox;
use slo_accel::Curved;
use slo_accel::curved::Part;
use slo_scene::animation::DAffine;
use slo_scene::shape::Cone;

impl CurvedSurface for Cone {
    fn primitive(&self, place: &DAffine) -> Curved {
        let [base, apex] = [self.base, self.apex].map(|p| place.point(p).as_vec3());
        Curved::Cone { base, apex, radius: place.length(self.radius) as f32 }
    }

    fn bounds(&self) -> ObjectBox {
        about_balls(&[self.base, self.apex], self.radius)
    }

    fn axis(&self) -> [DVec3; 2] {
        [self.base, self.apex - self.base]
    }

    fn uv_at(&self, point: Vec3, part: Part) -> [f32; 2] {
        uv_about(self.axis(), self.radius, point, part, |along, length| along / length)
    }
}
