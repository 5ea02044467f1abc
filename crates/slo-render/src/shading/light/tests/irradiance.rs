//! The irradiance of each lamp against closed forms.

use std::f64::consts::{PI, TAU};

use super::*;

fn close(found: f64, expected: f64, by: f64, what: &str) {
    let error = (found - expected).abs();
    assert!(error <= by * expected.abs().max(1e-9), "{what}: {found} instead of {expected}");
}

#[test]
fn points_and_spheres_shine_like_points_from_afar() {
    let position = DVec3::new(1.0, 2.0, 3.0);
    for (radius, distances) in [
        (0.0, &[0.01, 1.0, 1e4][..]),
        (0.5, &[0.5001, 0.6, 2.0, 1e3, 1e6]),
        (1e-3, &[0.01, 1.0, 30.0]),
    ] {
        let lamp = sphere(position, radius);
        for &distance in distances {
            let way = DVec3::new(2.0, -1.0, 2.0) / 3.0;
            let from = position - way * distance;
            let found = irradiance(&lamp, from.as_vec3(), way.as_vec3(), 1 << 16);
            let expected = 7.0 / (4.0 * PI * distance * distance);
            close(found, expected, 2e-3, &format!("radius {radius}, distance {distance}"));
        }
    }
}

#[test]
fn nothing_is_not_a_number_inside_a_sphere_or_at_a_point() {
    for (radius, offset) in [(0.5, 0.0), (0.5, 0.3), (0.5, 0.5), (0.0, 0.0)] {
        let lamp = sphere(DVec3::ONE, radius);
        for u in points(64) {
            let from = Vec3::ONE + Vec3::X * offset;
            let (way, radiance, density) = lamp.with(Sample(from, u));
            assert!(way.is_finite() && radiance.is_finite(), "{way} {radiance}");
            assert!(density == f32::INFINITY || offset == 0.5, "{density}");
        }
    }
}

/// The points sampled of a sphere lie on it, on the side of the hit.
#[test]
fn spheres_are_sampled_on_their_surface() {
    for (radius, distance) in [(1.0, 1.0001), (1.0, 3.0), (0.1, 20.0), (30.0, 31.0)] {
        let lamp = sphere(DVec3::ZERO, radius);
        let from = Vec3::new(0.6, 0.0, 0.8) * distance as f32;
        for u in points(1000) {
            let (way, ..) = lamp.with(Sample(from, u));
            let point = from + way;
            let error = (f64::from(point.length()) - radius).abs();
            // At the rim, an error of the direction moves the point far along the way.
            let slack = 1e-5 * distance + 1e-4 * radius;
            assert!(error < slack, "{error} off a sphere of {radius} from {distance}");
            assert!(point.dot(from) > 0.0);
        }
    }
}

fn spot(radius: f64, angle_deg: f32, blend: f32) -> Light {
    let (position, axis) = (DVec3::new(0.0, 0.0, 4.0), DVec3::NEG_Z);
    let power = [7.0, 5.0, 3.0];
    let lamp = scene::SpotLamp { power, position, radius, axis, angle_deg, blend };
    light(LightKind::SpotLamp(lamp), &[])
}

/// The irradiance below a spot lamp follows Blender's smoothstep, and what leaves the cone is its
/// power.
#[test]
fn spots_shine_into_their_cones() {
    for (angle, blend) in [(1.0, 0.3), (40.0, 0.0), (40.0, 0.5), (120.0, 1.0), (180.0, 0.2)] {
        for radius in [0.0, 1e-4] {
            let lamp = spot(radius, angle, blend);
            let rim = libm::cos(f64::from(angle).to_radians() * 0.5);
            let intensity = 7.0 / (TAU * (1.0 - rim));
            let share = |cos: f64| {
                let x = ((cos - rim) / ((1.0 - rim) * f64::from(blend)).max(1e-12)).clamp(0.0, 1.0);
                x * x * (3.0 - 2.0 * x)
            };
            let mut flux = 0.0;
            for i in 0..200 {
                let cos = 1.0 - (f64::from(i) + 0.5) / 200.0 * (1.0 - rim) * 1.2;
                if cos < -1.0 {
                    continue;
                }
                let sin = (1.0 - cos * cos).max(0.0).sqrt();
                let way = DVec3::new(-sin, 0.0, cos);
                let from = DVec3::new(0.0, 0.0, 4.0) - way * 3.0;
                let found = irradiance(&lamp, from.as_vec3(), way.as_vec3(), 64) * 9.0;
                let near_rim =
                    (cos - rim).abs() < 0.02 * (1.0 - rim) && (radius > 0.0 || blend == 0.0);
                if !near_rim {
                    let error = (found - intensity * share(cos)).abs() / intensity;
                    let most = if radius > 0.0 { 2e-2 } else { 1e-3 };
                    assert!(error < most, "{angle} {blend} {radius}, cos {cos}: {error}");
                }
                flux += found * TAU * (1.0 - rim) * 1.2 / 200.0;
            }
            if blend == 0.0 {
                close(flux, 7.0, 0.02, "flux");
            }
        }
    }
}

#[test]
fn suns_give_their_irradiance() {
    let direction = DVec3::new(0.48, -0.6, -0.64);
    for angle in [0.0, 1e-3, 0.01, 0.53, 30.0, 90.0, 180.0] {
        let lamp = sun(direction, angle);
        assert_eq!(lamp.is_area(), angle > 0.0);
        let found = irradiance(&lamp, Vec3::ONE, -direction.as_vec3(), 1 << 16);
        close(found, 7.0, 1e-3, &format!("{angle} degrees"));
    }
}

/// Lambert's formula: the irradiance of a polygon that lies above the horizon.
fn polygon(corners: &[DVec3], from: DVec3, normal: DVec3, radiance: f64) -> f64 {
    let ways: Vec<_> = corners.iter().map(|c| (*c - from).normalize()).collect();
    let edge = |i: usize| {
        let (a, b) = (ways[i], ways[(i + 1) % ways.len()]);
        libm::acos(a.dot(b).clamp(-1.0, 1.0)) * a.cross(b).normalize().dot(normal)
    };
    radiance * 0.5 * (0..ways.len()).map(edge).sum::<f64>().abs()
}

#[test]
fn rectangles_and_triangles_follow_lamberts_formula() {
    let corners = [
        DVec3::new(-1.0, -1.0, 2.0),
        DVec3::new(-1.0, 2.0, 2.5),
        DVec3::new(2.0, 2.0, 2.5),
        DVec3::new(2.0, -1.0, 2.0),
    ];
    let below = [DVec3::ZERO, DVec3::new(1.5, 1.0, 0.5), DVec3::new(30.0, 5.0, -90.0)];
    for from in below {
        for normal in [DVec3::Z, DVec3::new(0.1, 0.2, 0.97).normalize()] {
            let expected = polygon(&corners, from, normal, 7.0);
            let [from, n] = [from, normal].map(|v| v.as_vec3());
            for (two_sided, lit) in [(false, true), (true, true)] {
                let lamp = rectangle([corners[0], corners[1], corners[2]], two_sided);
                let found = irradiance(&lamp, from, n, 1 << 18);
                close(found, if lit { expected } else { 0.0 }, 2e-3, "rectangle");
            }
            let back = rectangle([corners[2], corners[1], corners[0]], false);
            assert_eq!(irradiance(&back, from, n, 100), 0.0);
            let [a, b, c, _] = corners.map(|c| c.as_vec3());
            let triangle = Light::Triangle(Triangle::new([a, b, c], Vec3::splat(7.0)));
            let expected = polygon(&corners[..3], from.as_dvec3(), normal, 7.0);
            close(irradiance(&triangle, from, n, 1 << 18), expected, 2e-3, "triangle");
        }
    }
    // A rectangle of 2 x 1 over its middle, at a distance of 1.5.
    let vertices =
        [DVec3::new(-1.0, -0.5, 1.5), DVec3::new(-1.0, 0.5, 1.5), DVec3::new(1.0, 0.5, 1.5)];
    let part = |x: f64, y: f64| {
        let root = (1.5 * 1.5 + x * x).sqrt();
        x / root * libm::atan(y / root)
    };
    let expected = 2.0 * 7.0 * (part(1.0, 0.5) + part(0.5, 1.0));
    let found = irradiance(&rectangle(vertices, false), Vec3::ZERO, Vec3::Z, 1 << 18);
    close(found, expected, 1e-3, "over the middle");
}

/// At any distance and slant; and all points of a lamp that is not small are as likely.
#[test]
fn rectangles_follow_lamberts_formula_near_and_far() {
    let (a, b) = (DVec3::new(0.8, 0.0, 0.6), DVec3::new(0.0, 0.3, 0.0));
    for place in [DVec3::ZERO, DVec3::new(70.0, -30.0, 20.0)] {
        for height in [2e-3, 0.02, 0.3, 2.0, 20.0, 900.0] {
            for aside in [0.5, 1.02, 3.0] {
                let corner = place - a * aside - b * 0.4;
                let (corners, up) = ([corner, corner + a, corner + a + b], a.cross(b).normalize());
                let from = (place - up * height).as_vec3();
                let normal = if aside < 1.0 { up } else { (up - a * 0.4).normalize() };
                let lamp = rectangle(corners, true);
                let four = [corner, corner + a, corner + a + b, corner + b];
                let expected = polygon(&four, from.as_dvec3(), normal, 7.0);
                let found = irradiance(&lamp, from, normal.as_vec3(), 1 << 18);
                // Corners far from the origin are rounded.
                let slack = 3e-3 + 2e-7 * place.length() / height;
                close(found, expected, slack, &format!("{height} below, {aside} aside"));
                if aside < 1.0 && height < 10.0 {
                    let density = |u| lamp.with(Sample(from, u)).2;
                    let first = density([0.5; 2]);
                    assert!(points(100).all(|u| density(u) == first), "{height} below");
                }
            }
        }
    }
}

#[test]
fn discs_follow_their_formula() {
    for normal in [DVec3::NEG_Z, DVec3::new(0.6, 0.0, 0.8)] {
        for (radius, distance) in [(1.0, 0.5), (1.0, 3.0), (0.01, 3.0)] {
            let center = DVec3::new(5.0, 1.0, 2.0);
            let from = (center + normal * distance).as_vec3();
            let lamp = disc(center, normal, radius);
            let expected = PI * 7.0 * radius * radius / (distance * distance + radius * radius);
            close(irradiance(&lamp, from, -normal.as_vec3(), 1 << 18), expected, 2e-3, "disc");
            let behind = (center - normal * distance).as_vec3();
            assert_eq!(irradiance(&lamp, behind, normal.as_vec3(), 100), 0.0);
        }
    }
}

#[test]
fn skies_light_from_all_around() {
    let even = scene::Environment { sky: Sky::Even([7.0; 3]), strength: 2.0, turn_deg: 0.0 };
    let even = light(LightKind::Environment(even), &[]);
    let white = Arc::new(Texture::from_rgb8(100, 70, vec![255; 21_000]).unwrap());
    let image = scene::Environment {
        sky: Sky::Image(slo_scene::TextureId(0)),
        strength: 14.0,
        turn_deg: 77.0,
    };
    let image = light(LightKind::Environment(image), &[white]);
    for lamp in [even, image] {
        for normal in [Vec3::Z, Vec3::NEG_X, Vec3::new(0.6, 0.64, -0.48)] {
            close(irradiance(&lamp, Vec3::ONE, normal, 1 << 18), 14.0 * PI, 2e-3, "sky");
        }
        let energy = f64::from(lamp.bounds().energy);
        close(energy, 14.0 * PI, 1e-3, "energy");
    }
}

/// Sampling an image of the sky by its table gives the sum over all directions.
#[test]
fn images_of_the_sky_lose_no_light() {
    for (width, height, turn) in
        [(2, 1, 0.0), (16, 8, 30.0), (300, 151, -400.0), (3000, 1100, 90.0)]
    {
        let lamp = sky(width, height, turn);
        let Light::ImageSky(image) = &lamp else { panic!("an image") };
        for normal in [Vec3::Z, Vec3::NEG_Y] {
            let mut by_all = 0.0;
            let count = 1 << 20;
            for u in points(count) {
                let way = EvenSky::new(Vec3::ONE).way(Vec3::ZERO, u);
                by_all +=
                    f64::from(image.view().radiance(way).x * way.dot(normal).max(0.0)) * 4.0 * PI;
            }
            let by_table = irradiance(&lamp, Vec3::ZERO, normal, 1 << 18);
            close(by_table, by_all / f64::from(count), 0.02, &format!("{width} {normal}"));
        }
    }
}

#[test]
fn the_middle_of_the_image_is_x_and_turns_toward_y() {
    // Left to right: -x, between, +x, between; the top is red.
    let mut texels = vec![0; 4 * 3 * 3];
    for (x, color) in [(0, 10u8), (1, 20), (2, 30), (3, 40)] {
        texels[(4 + x) * 3 + 1] = color;
    }
    for texel in texels[..12].chunks_exact_mut(3) {
        texel[0] = 255;
    }
    let texture =
        Arc::new(Texture::from_rgb8(4, 3, texels).unwrap().with_encoding(Some(Curve::Raw)));
    let of = |turn_deg: f32, way: Vec3| {
        let sky = Sky::Image(slo_scene::TextureId(0));
        let lamp = scene::Environment { sky, strength: 255.0, turn_deg };
        light(LightKind::Environment(lamp), std::slice::from_ref(&texture)).radiance(way)
    };
    // The middle lies between texels 1 and 2; +y is a quarter to the left of it, between 0 and 1.
    for (turn, way, expected) in [
        (0.0, Vec3::X, 25.0),
        (0.0, Vec3::Y, 15.0),
        (0.0, Vec3::NEG_Y, 35.0),
        (0.0, Vec3::NEG_X, 25.0),
        (90.0, Vec3::Y, 25.0),
        (90.0, Vec3::NEG_X, 15.0),
        (-270.0, Vec3::Y, 25.0),
    ] {
        let green = of(turn, way).y;
        assert!((green - expected).abs() < 1e-3, "{turn} {way}: {green}");
    }
    assert!((of(0.0, Vec3::Z).x - 255.0).abs() < 1e-3);
    assert_eq!(of(0.0, Vec3::NEG_Z).x, 0.0);
}
