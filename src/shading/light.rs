//! Lights in render space.

use glam::{DVec3, Vec3};

use crate::math::rounding::gamma;
use crate::scene::{self, LightShape};

/// A light.
#[derive(Clone, Copy, Debug)]
pub struct Light {
    /// Radiance that reaches a hit, whatever its distance.
    pub color: Vec3,
    /// First corner, or the position of a point light.
    corner: Vec3,
    /// Sides of the rectangle; 0 for a point light.
    sides: [Vec3; 2],
    /// Unit normal of the rectangle.
    normal: Vec3,
    /// Bound of the rounding errors of a point of the light, along its normal.
    offset: f32,
}

impl Light {
    /// The light with the origin of render space at `origin` of scene space.
    pub fn new(light: &scene::Light, origin: DVec3) -> Self {
        let color = light.color.into();
        match light.shape {
            LightShape::Point { position } => Self {
                color,
                corner: (position - origin).as_vec3(),
                sides: [Vec3::ZERO; 2],
                normal: Vec3::Z,
                offset: 0.0,
            },
            LightShape::Rectangle { vertices: [v0, v1, v2] } => {
                let sides = [v1 - v0, v2 - v1];
                let normal = sides[0].cross(sides[1]).normalize_or(DVec3::Z).as_vec3();
                let far = (v0 - origin).abs() + sides[0].abs() + sides[1].abs();
                Self {
                    color,
                    corner: (v0 - origin).as_vec3(),
                    sides: sides.map(|s| s.as_vec3()),
                    normal,
                    offset: normal.abs().dot(far.as_vec3()) * gamma(32),
                }
            }
        }
    }

    /// Whether the light has an area to be sampled.
    pub fn is_area(&self) -> bool {
        self.sides[0] != Vec3::ZERO
    }

    /// The point `(u, v)` of the light, uniform by area. Source: thesis 5.11.
    #[inline(always)]
    pub fn point(&self, u: [f32; 2]) -> Vec3 {
        self.corner + self.sides[0] * u[0] + self.sides[1] * u[1]
    }

    /// Direction of a shadow ray from `from` to a `point` of the light, and the t at which it ends:
    /// 1, less what keeps the light's own rectangle from being hit.
    ///
    /// The test of the rectangle may be off along its normal by the roundings of its corners as
    /// seen from `from`, and along the ray by more, the flatter the ray comes in.
    #[inline(always)]
    pub fn shadow_ray(&self, from: Vec3, point: Vec3) -> (Vec3, f32) {
        let direction = point - from;
        if !self.is_area() {
            return (direction, 1.0);
        }
        let far = (self.corner - from).abs() + self.sides[0].abs() + self.sides[1].abs();
        let error = self.offset + far.max_element() * gamma(32);
        // A ray in the rectangle's plane is kept as long as half its way.
        (direction, (1.0 - error / direction.dot(self.normal).abs()).max(0.5))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_fill_the_rectangle_and_shadow_rays_end_before_it() {
        let vertices =
            [DVec3::new(1.0, 1.0, 5.0), DVec3::new(3.0, 1.0, 5.0), DVec3::new(3.0, 4.0, 5.0)];
        let light = scene::Light {
            name: "l".into(),
            color: [1.0; 3],
            shape: LightShape::Rectangle { vertices },
        };
        let light = Light::new(&light, DVec3::ZERO);
        assert!(light.is_area());
        assert_eq!(light.point([1.0, 1.0]), Vec3::new(3.0, 4.0, 5.0));
        let p = light.point([0.5, 0.5]);
        assert_eq!(p, Vec3::new(2.0, 2.5, 5.0));
        for from in [Vec3::ZERO, Vec3::new(0.0, 0.0, 9.0), Vec3::new(-50.0, 70.0, 4.9)] {
            let (direction, t_max) = light.shadow_ray(from, p);
            assert_eq!(direction, p - from);
            let end = from + direction * t_max;
            assert!(t_max < 1.0 && (end - p).length() < 0.02, "{t_max} from {from}");
            assert!((end.z < 5.0) == (from.z < 5.0));
        }
        let (_, edge_on) = light.shadow_ray(Vec3::new(-9.0, 2.0, 5.0), p);
        assert_eq!(edge_on, 0.5);
    }
}
