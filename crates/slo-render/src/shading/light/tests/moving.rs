//! Lamps that move against lamps that stand where they are.

use glam::Mat3;

use super::*;

/// What a hit finds of a lamp in a pose: vector to a point, radiance, density, end of shadow rays.
struct Found(Pose, Vec3, [f32; 2]);

impl WithLamp for Found {
    type Output = (Vec3, Vec3, f32, Vec3, f32);

    fn run<L: Lamp>(self, lamp: L) -> Self::Output {
        let Self(pose, from, u) = self;
        let lamp = Moving { lamp, pose };
        let way = lamp.way(from, u);
        let point = if L::IS_DISTANT { way } else { from + way };
        let (direction, t_max) = lamp.shadow_ray(from, point);
        (way, lamp.radiance(way), lamp.density(from, way), direction, t_max)
    }
}

#[test]
fn a_lamp_in_a_pose_is_the_lamp_that_stands_there() {
    // A quarter of a turn about z, and a step.
    let rotation = Mat3::from_cols(Vec3::Y, Vec3::NEG_X, Vec3::Z);
    let step = DVec3::new(3.0, -2.0, 0.5);
    let pose = Pose { rotation, translation: step.as_vec3() };
    let turned = |v: DVec3| DVec3::new(-v.y, v.x, v.z);
    let place = |p: DVec3| turned(p) + step;
    let corners = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 0.0, 2.0)];
    let axis = DVec3::new(0.6, 0.0, -0.8);
    let pairs = [
        (sphere(axis, 0.0), sphere(place(axis), 0.0)),
        (sphere(axis, 0.5), sphere(place(axis), 0.5)),
        (rectangle(corners, false), rectangle(corners.map(place), false)),
        (sun(axis, 0.0), sun(turned(axis), 0.0)),
        (sun(axis, 20.0), sun(turned(axis), 20.0)),
        (spot_at(axis, axis, 0.0, 90.0), spot_at(place(axis), turned(axis), 0.0, 90.0)),
        (sky(16, 8, 0.0), sky(16, 8, 90.0)),
    ];
    for (number, (moving, there)) in pairs.iter().enumerate() {
        for u in points(100) {
            let from = Vec3::new(2.5, 4.0, -1.0);
            let (way, radiance, density, direction, t_max) = moving.with(Found(pose, from, u));
            if moving.is_area() && matches!(number, 2 | 6) {
                let (expected, ..) = there.with(Sample(from, u));
                assert!((way - expected).length() < 1e-4, "{number}: {way}, {expected}");
            }
            let expected = (there.radiance(way), there.density(from, way));
            assert!((radiance - expected.0).length() <= 1e-3 * expected.0.length(), "{number}");
            let same = density == expected.1 || (density / expected.1 - 1.0).abs() < 1e-3;
            assert!(same, "{number}: {density}, {}", expected.1);
            assert_eq!(t_max.is_infinite(), there.is_distant());
            assert!((direction - way).length() < 1e-5);
        }
        let bounds = moving.bounds().in_poses(std::iter::once((rotation, pose.translation)));
        let expected = there.bounds();
        assert!(bounds.min.cmple(expected.min + 1e-5).all(), "{bounds:?} {expected:?}");
        assert!(bounds.max.cmpge(expected.max - 1e-5).all(), "{bounds:?} {expected:?}");
        assert!((bounds.axis - expected.axis).length() < 1e-5 || bounds.spread > 3.0);
        assert!((bounds.energy - expected.energy).abs() <= 1e-3 * expected.energy);
    }
}

#[test]
fn a_ray_finds_the_pose_of_its_time() {
    let pose = |x: f32| Pose { translation: Vec3::X * x, ..Pose::IDENTITY };
    let lights: Lights = [sphere(DVec3::ZERO, 0.0), sphere(DVec3::ZERO, 0.0)].into_iter().collect();
    assert!(!lights.move_about());
    let of = |paths: [Vec<Pose>; 2]| {
        let mut poses = Poses::default();
        paths.into_iter().for_each(|path| poses.add(1, path));
        poses
    };
    let lights = lights.with_poses(of([vec![], vec![pose(0.0), pose(1.0), pose(2.0)]]));
    assert!(lights.move_about());
    for (light, time, x) in [(0, 0.7, 0.0), (1, 0.0, 0.0), (1, 0.3, 1.0), (1, 1.0, 2.0)] {
        assert_eq!(lights.pose(light, time).translation.x, x);
    }
    let still = lights.clone().with_poses(of([vec![], vec![]]));
    assert!(!still.move_about());
    // The lamp moves away from a hit at x = 4: from 4 to 2 units away.
    let way = |x: f32| Vec3::X * (x - 4.0);
    let radiance = |time: f32, x: f32| lights.radiance(1, time, way(x)).x;
    assert!((radiance(1.0, 2.0) / radiance(0.0, 0.0) - 4.0).abs() < 1e-4);
}
