//! `cylinder`

use glam::{DVec3, Vec3};

use super::geometry::CurvedSurface;
use super::round::{about_balls, uv_about};
use crate::frame::sampled_motion::ObjectBox;
use slo_accel::Curved;
use slo_accel::curved::Part;
use slo_scene::animation::DAffine;
use slo_scene::shape::Cylinder;

impl CurvedSurface for Cylinder {
    fn primitive(&self, place: &DAffine) -> Curved {
        let [base, top] = [self.base, self.top].map(|p| place.point(p).as_vec3());
        Curved::Cylinder { base, top, radius: place.length(self.radius) as f32 }
    }

    fn bounds(&self) -> ObjectBox {
        about_balls(&[self.base, self.top], self.radius)
    }

    fn axis(&self) -> [DVec3; 2] {
        [self.base, self.top - self.base]
    }

    fn uv_at(&self, point: Vec3, part: Part) -> [f32; 2] {
        uv_about(self.axis(), self.radius, point, part, |along, length| along / length)
    }
}
