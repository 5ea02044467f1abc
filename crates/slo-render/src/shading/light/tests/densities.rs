//! Samples against their densities.

use rand::{RngExt, SeedableRng, rngs::StdRng};

use super::*;

/// Cells of the sphere: by z, and by the angle about z.
const CELLS: [usize; 2] = [24, 48];

fn cell(way: Vec3) -> usize {
    let way = way.normalize().as_dvec3();
    let turn = libm::atan2(way.y, way.x) / std::f64::consts::TAU;
    let at = |x: f64, count: usize| ((x * count as f64) as usize).min(count - 1);
    at((way.z + 1.0) * 0.5, CELLS[0]) * CELLS[1] + at(turn - turn.floor(), CELLS[1])
}

/// The vector from the hit to the point of the light in a unit direction, if the light is there.
type Find<'a> = &'a dyn Fn(Vec3) -> Option<Vec3>;

/// Returns the integral of the density, and by how many standard deviations the counts of samples
/// in cells differ from it, by chi-square.
fn check(light: &Light, from: Vec3, find: Find<'_>, planted: f32) -> (f64, f64) {
    const FINE: usize = 40;
    let count = 400_000;
    let mut expected = vec![0.0; CELLS[0] * CELLS[1]];
    let (rows, columns) = (CELLS[0] * FINE, CELLS[1] * FINE);
    for row in 0..rows {
        let z = (row as f64 + 0.5) / rows as f64 * 2.0 - 1.0;
        let sin = (1.0 - z * z).sqrt();
        for column in 0..columns {
            let angle = (column as f64 + 0.5) / columns as f64 * std::f64::consts::TAU;
            let way = DVec3::new(sin * libm::cos(angle), sin * libm::sin(angle), z).as_vec3();
            let density = find(way).map_or(0.0, |way| light.density(from, way));
            expected[row / FINE * CELLS[1] + column / FINE] +=
                f64::from(density) * 4.0 * std::f64::consts::PI / (rows * columns) as f64;
        }
    }
    let mut counts = vec![0u32; expected.len()];
    let mut rng = StdRng::seed_from_u64(7);
    for _ in 0..count {
        let u = [rng.random_range(0.0..1.0), rng.random_range(0.0..1.0f32)];
        let (way, ..) = light.with(Sample(from, [u[0] * planted, u[1]]));
        counts[cell(way)] += 1;
    }
    let (mut chi2, mut freedom) = (0.0, -1.0);
    let (mut few, mut few_counted) = (0.0, 0.0);
    for (expected, counted) in expected.iter().zip(counts) {
        let (expected, counted) = (expected * f64::from(count), f64::from(counted));
        if expected < 20.0 {
            (few, few_counted) = (few + expected, few_counted + counted);
        } else {
            chi2 += (counted - expected) * (counted - expected) / expected;
            freedom += 1.0;
        }
    }
    if few > 0.0 || few_counted > 0.0 {
        let few = f64::max(few, 1.0);
        chi2 += (few_counted - few) * (few_counted - few) / few;
        freedom += 1.0;
    }
    let freedom = f64::max(freedom, 1.0);
    (expected.iter().sum(), (chi2 - freedom) / (2.0 * freedom).sqrt())
}

/// Checks a light, and that a planted bias is found.
fn assert_fits(light: &Light, from: Vec3, find: Find<'_>, what: &str) {
    let (sum, deviation) = check(light, from, find, 1.0);
    assert!((sum - 1.0).abs() < 2e-3, "{what}: the density sums to {sum}");
    assert!(deviation < 6.0, "{what}: {deviation} standard deviations");
    let (_, planted) = check(light, from, find, 0.97);
    assert!(planted > 6.0, "{what}: a bias is not found: {planted}");
}

/// The way to a plane, in a unit direction.
fn to_plane(way: Vec3, from: Vec3, point: Vec3, normal: Vec3) -> Option<Vec3> {
    let t = (point - from).dot(normal) / way.dot(normal);
    (t > 0.0 && t.is_finite()).then_some(way * t)
}

#[test]
fn spheres() {
    let center = Vec3::new(1.0, 0.5, 2.0);
    for (radius, from) in [(1.0f32, Vec3::ZERO), (2.2, Vec3::ZERO), (1.0, Vec3::new(3.0, 0.0, 5.0))]
    {
        let find = |way: Vec3| {
            let to = center - from;
            let b = to.dot(way);
            let across = to.length_squared() - b * b;
            (b > 0.0 && across < radius * radius).then_some(way)
        };
        assert_fits(&sphere(center.as_dvec3(), radius.into()), from, &find, "sphere");
    }
}

#[test]
fn rectangles_discs_and_triangles() {
    let from = Vec3::new(0.3, 0.2, 0.1);
    let corners =
        [DVec3::new(-1.0, -1.0, 1.2), DVec3::new(2.0, -1.0, 1.7), DVec3::new(2.0, 1.5, 1.7)];
    let [a, b, c] = corners.map(|c| c.as_vec3());
    let (x, y) = (b - a, c - b);
    let normal = x.cross(y).normalize();
    let inside =
        |p: Vec3| [(p - a).dot(x) / x.length_squared(), (p - a).dot(y) / y.length_squared()];
    let find = |way: Vec3| {
        let way = to_plane(way, from, a, normal)?;
        let [s, t] = inside(from + way);
        [s, t].iter().all(|at| (0.0..=1.0).contains(at)).then_some(way)
    };
    assert_fits(&rectangle(corners, true), from, &find, "rectangle");
    let find = |way: Vec3| {
        let way = to_plane(way, from, a, normal)?;
        let [s, t] = inside(from + way);
        (t >= 0.0 && s <= 1.0 && s >= t).then_some(way)
    };
    let triangle = Light::Triangle(Triangle::new([a, b, c], Vec3::ONE));
    assert_fits(&triangle, from, &find, "triangle");
    let find = |way: Vec3| {
        let way = to_plane(way, from, a, normal)?;
        ((from + way).distance(a) < 1.5).then_some(way)
    };
    assert_fits(&disc(a.as_dvec3(), normal.as_dvec3(), 1.5), from, &find, "disc");
}

/// Close to it, behind it, beside it, and at a grazing angle.
#[test]
fn rectangles_nearby() {
    let corners = [DVec3::ZERO, DVec3::new(1.2, 0.9, 0.0), DVec3::new(0.6, 1.7, 0.0)];
    let [a, b, c] = corners.map(|c| c.as_vec3());
    let (x, y) = (b - a, c - b);
    for from in [
        Vec3::new(0.5, 0.7, 0.03),
        Vec3::new(0.5, 0.7, -0.1),
        Vec3::new(1.3, 0.9, 0.05),
        Vec3::new(-0.4, 0.5, 0.02),
        Vec3::new(4.0, 0.5, 1.0),
    ] {
        let find = |way: Vec3| {
            let way = to_plane(way, from, a, Vec3::Z)?;
            let at = from + way - a;
            let shares = [at.dot(x) / x.length_squared(), at.dot(y) / y.length_squared()];
            shares.iter().all(|at| (0.0..=1.0).contains(at)).then_some(way)
        };
        assert_fits(&rectangle(corners, true), from, &find, "rectangle");
    }
}

#[test]
fn suns_and_skies() {
    let sun = sun(DVec3::new(0.48, -0.6, -0.64), 80.0);
    assert_fits(&sun, Vec3::ONE, &Some, "sun");
    let even = scene::Environment { sky: Sky::Even([1.0; 3]), strength: 1.0, turn_deg: 0.0 };
    assert_fits(&light(LightKind::Environment(even), &[]), Vec3::ONE, &Some, "even sky");
    for (width, height, turn) in [(2, 1, 0.0), (16, 8, 30.0), (300, 151, -400.0)] {
        assert_fits(&sky(width, height, turn), Vec3::ONE, &Some, "image of the sky");
    }
}
