//! `light_rectangle`: a rectangle that emits light on both sides.

use std::f32::consts::PI;

use glam::{DVec3, Vec3};

use super::bounds::LightBounds;
use super::lamp::{Lamp, luminance};
use slo_accel::math::rounding::gamma;
use slo_scene::light::RectangleLight;

/// A rectangle.
#[derive(Clone, Copy, Debug)]
pub struct Rectangle {
    /// Radiance that reaches a hit, at any distance (lights have no falloff).
    pub(super) color: Vec3,
    /// First corner.
    pub(super) corner: Vec3,
    pub(super) sides: [Vec3; 2],
    /// Unit normal.
    pub(super) normal: Vec3,
    /// Absolute values of the components of `normal`, times the rounding bound of
    /// [`shadow_ray`](Lamp::shadow_ray).
    pub(super) sensitivity: Vec3,
    /// Upper bound of the absolute coordinates from which points of the light are computed.
    pub(super) magnitude: Vec3,
    pub(super) area: f32,
}

impl Rectangle {
    /// Converts a light of the scene; `origin` is the origin of render space in scene space.
    pub fn new(light: &RectangleLight, origin: DVec3) -> Self {
        let [v0, v1, v2] = light.rectangle.vertices;
        let sides = [v1 - v0, v2 - v1];
        let normal = sides[0].cross(sides[1]).normalize_or(DVec3::Z).as_vec3();
        let far = (v0 - origin).abs() + sides[0].abs() + sides[1].abs();
        Self {
            color: light.color.into(),
            corner: (v0 - origin).as_vec3(),
            sides: sides.map(|s| s.as_vec3()),
            normal,
            sensitivity: normal.abs() * gamma(32),
            magnitude: far.as_vec3(),
            area: sides[0].cross(sides[1]).length() as f32,
        }
    }

    /// Returns the corners.
    pub(super) fn corners(&self) -> [Vec3; 4] {
        let [a, b] = self.sides;
        [Vec3::ZERO, a, b, a + b].map(|side| self.corner + side)
    }
}

impl Lamp for Rectangle {
    const IS_AREA: bool = true;
    const IS_DELTA: bool = false;
    const IS_OF_THESIS: bool = true;

    #[inline(always)]
    fn radiance(&self, _way: Vec3) -> Vec3 {
        self.color
    }

    /// Samples uniformly by area. Source: thesis 5.11.
    #[inline(always)]
    fn point(&self, _from: Vec3, u: [f32; 2]) -> Vec3 {
        self.corner + self.sides[0] * u[0] + self.sides[1] * u[1]
    }

    #[inline(always)]
    fn density(&self, _from: Vec3, way: Vec3) -> f32 {
        let square = way.length_squared();
        square * square.sqrt() / (way.dot(self.normal).abs() * self.area)
    }

    /// The sampled point differs from the rectangle by roundings of its coordinates. The
    /// rectangle's intersection test rounds the corners relative to `from`, sheared along the ray.
    /// Both errors count along the normal only, so that a ray at a grazing angle ends no earlier
    /// than necessary: 6 roundings of the point and the direction, 10 of the test, and as many
    /// again for the slope of the ray, which is rounded too. The rest of the bound covers a ray
    /// that starts again behind a transparent object.
    #[inline(always)]
    fn shadow_ray(&self, from: Vec3, point: Vec3) -> (Vec3, f32) {
        let direction = point - from;
        let far = (self.corner - from).abs() + self.sides[0].abs() + self.sides[1].abs();
        let along = direction.abs();
        // The shear moves a corner as far as the ray moves sideways on its way to that depth.
        let sheared = along * (far.max_element() / along.max_element());
        let error = self.sensitivity.dot(self.magnitude + far + sheared);
        // A ray in the rectangle's plane keeps half its length.
        (direction, (1.0 - error / direction.dot(self.normal).abs()).max(0.5))
    }

    fn area(&self) -> f32 {
        self.area
    }

    fn normal(&self, _point: Vec3) -> Vec3 {
        self.normal
    }

    /// It shines all round, since the cosine at the light does not count.
    fn bounds(&self) -> LightBounds {
        let energy = PI * luminance(self.color);
        let flat = LightBounds::flat(&self.corners(), self.normal, true, energy);
        LightBounds { falls_off: false, ..LightBounds::all_round([flat.min, flat.max], energy) }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng, rngs::StdRng};

    use super::*;
    use slo_accel::triangle::{ShearedRay, intersect};

    fn light(vertices: [DVec3; 3]) -> Rectangle {
        let rectangle = slo_scene::shape::Rectangle { vertices };
        Rectangle::new(&RectangleLight { color: [1.0; 3], rectangle }, DVec3::ZERO)
    }

    #[test]
    fn points_fill_the_rectangle_and_shadow_rays_end_before_it() {
        let vertices =
            [DVec3::new(1.0, 1.0, 5.0), DVec3::new(3.0, 1.0, 5.0), DVec3::new(3.0, 4.0, 5.0)];
        let light = light(vertices);
        assert_eq!(light.point(Vec3::ZERO, [1.0, 1.0]), Vec3::new(3.0, 4.0, 5.0));
        let p = light.point(Vec3::ZERO, [0.5, 0.5]);
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

    /// Rays to random points on lights of any size and slant, from nearby, from far away and almost
    /// in the light's plane, never hit the light's own triangles, but end just before them.
    #[test]
    fn shadow_rays_never_hit_their_own_light() {
        let mut rng = StdRng::seed_from_u64(19);
        let mut number = |scale: f64| rng.random_range(-1.0..1.0) * scale;
        let (mut longest, mut too_long) = (0, 0);
        for i in 0..20_000 {
            let mut vector = |scale: f64| DVec3::new(number(scale), number(scale), number(scale));
            let place = vector([0.0, 1.0, 1e3, 1e6][i % 4]);
            let size = [1e-2, 1.0, 30.0][i % 3];
            let (a, b) = (vector(size), vector(size));
            let vertices = [place, place + a, place + a + a.cross(b).normalize() * a.length()];
            let light = light(vertices);
            let fourth = vertices[0] + vertices[2] - vertices[1];
            let [v0, v1, v2, v3] =
                [vertices[0], vertices[1], vertices[2], fourth].map(|v| v.as_vec3());
            let away = vector([1.0, 1e2, 1e4][i % 5 % 3]);
            let away = if i % 7 < 3 { away * 1e-3 + a * number(9.0) } else { away };
            let from = (place + away).as_vec3();
            let u = [number(0.5) + 0.5, number(0.5) + 0.5].map(|u| u as f32);
            let (direction, t_max) = light.shadow_ray(from, light.point(from, u));
            let ray = ShearedRay::new(from, direction);
            // An edge-on ray, which ends half way, may still hit the light.
            for triangle in [[v0, v1, v2], [v0, v2, v3]].iter().filter(|_| t_max > 0.5) {
                assert_eq!(intersect(&ray, triangle, t_max), None, "{light:?} from {from}");
                let longer = 1.0 - (1.0 - t_max) / 32.0;
                too_long += usize::from(intersect(&ray, triangle, longer).is_some());
            }
            longest += usize::from(t_max > 0.999);
        }
        assert!(longest > 10_000, "{longest}");
        assert!(too_long > 0, "a thirty-second of the bound would do");
    }
}
