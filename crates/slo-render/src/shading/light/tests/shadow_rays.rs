//! Shadow rays end before the lamp's own surface.

use rand::{RngExt, SeedableRng, rngs::StdRng};

use super::*;
use slo_accel::Curved;
use slo_accel::triangle::{ShearedRay, intersect};

struct ShadowRay(Vec3, [f32; 2]);

impl WithLamp for ShadowRay {
    type Output = (Vec3, f32);

    fn run<L: Lamp>(self, lamp: L) -> (Vec3, f32) {
        lamp.shadow_ray(self.0, self.0 + lamp.way(self.0, self.1))
    }
}

#[test]
fn of_spheres() {
    let mut rng = StdRng::seed_from_u64(5);
    let mut number = |scale: f64| rng.random_range(-1.0..1.0) * scale;
    let mut near = 0;
    for i in 0..50_000 {
        let mut vector = |scale: f64| DVec3::new(number(scale), number(scale), number(scale));
        let center = vector([0.0, 1.0, 1e3][i % 3]).as_vec3();
        let radius = [1e-2f32, 0.5, 20.0][i % 7 % 3];
        let away = vector(1.0).normalize_or(DVec3::X).as_vec3();
        let from = center + away * radius * [1.01, 2.0, 100.0, 1e4][i % 4];
        let lamp = sphere(center.as_dvec3(), radius.into());
        let u = [number(0.5) + 0.5, number(0.5) + 0.5].map(|u| u as f32);
        let (direction, t_max) = lamp.with(ShadowRay(from, u));
        if t_max > 0.5 {
            let hit = Curved::Sphere { center, radius }.intersect(from, direction, t_max);
            assert_eq!(hit, None, "{center} {radius} from {from} along {direction} to {t_max}");
        }
        near += usize::from(t_max > 0.99);
    }
    assert!(near > 30_000, "{near}");
}

#[test]
fn of_discs() {
    let mut rng = StdRng::seed_from_u64(5);
    let mut number = |scale: f64| rng.random_range(-1.0..1.0) * scale;
    let mut near = 0;
    for i in 0..50_000 {
        let mut vector = |scale: f64| DVec3::new(number(scale), number(scale), number(scale));
        let center = vector([0.0, 1.0, 1e3][i % 3]);
        let normal = vector(1.0).normalize_or(DVec3::X);
        let radius = [1e-2, 0.5, 20.0][i % 7 % 3];
        let from = (center + vector(1.0) * radius * [1.01, 2.0, 100.0, 1e4][i % 4]).as_vec3();
        let u = [number(0.5) + 0.5, number(0.5) + 0.5].map(|u| u as f32);
        let (direction, t_max) = disc(center, normal, radius).with(ShadowRay(from, u));
        if t_max > 0.5 {
            let (center, normal, radius) = (center.as_vec3(), normal.as_vec3(), radius as f32);
            let surface = Curved::Disc { center, normal, radius };
            let hit = surface.intersect(from, direction, t_max);
            assert_eq!(hit, None, "{surface:?} from {from} along {direction} to {t_max}");
        }
        near += usize::from(t_max > 0.99);
    }
    assert!(near > 30_000, "{near}");
}

#[test]
fn of_triangles() {
    let mut rng = StdRng::seed_from_u64(5);
    let mut number = |scale: f64| rng.random_range(-1.0..1.0) * scale;
    let mut near = 0;
    for i in 0..50_000 {
        let mut vector = |scale: f64| DVec3::new(number(scale), number(scale), number(scale));
        let place = vector([0.0, 1.0, 1e3, 1e6][i % 4]);
        let size = [1e-2, 1.0, 30.0][i % 3];
        let corners = [place, place + vector(size), place + vector(size)].map(|c| c.as_vec3());
        let lamp = Triangle::new(corners, Vec3::ONE);
        let from = (place + vector([1.0, 1e2, 1e4][i % 5 % 3])).as_vec3();
        let u = [number(0.5) + 0.5, number(0.5) + 0.5].map(|u| u as f32);
        let (direction, t_max) = Light::Triangle(lamp).with(ShadowRay(from, u));
        if t_max > 0.5 {
            let hit = intersect(&ShearedRay::new(from, direction), &corners, t_max);
            assert_eq!(hit, None, "{corners:?} from {from}");
        }
        near += usize::from(t_max > 0.99);
    }
    assert!(near > 30_000, "{near}");
}

#[test]
fn of_the_sky_have_no_end() {
    for lamp in [sun(DVec3::NEG_Z, 0.0), sun(DVec3::NEG_Z, 10.0), sky(8, 4, 0.0)] {
        assert!(lamp.is_distant());
        struct Ray;
        impl WithLamp for Ray {
            type Output = (Vec3, f32, Vec3);

            fn run<L: Lamp>(self, lamp: L) -> Self::Output {
                let way = lamp.way(Vec3::ONE, [0.3, 0.4]);
                let (direction, t_max) = lamp.shadow_ray(Vec3::ONE, way);
                (direction, t_max, way)
            }
        }
        let (direction, t_max, way) = lamp.with(Ray);
        assert_eq!((direction, t_max), (way, f32::INFINITY));
        assert!((way.length() - 1.0).abs() < 1e-5);
    }
}
