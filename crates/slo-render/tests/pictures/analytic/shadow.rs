//! Shadows of point lights and rectangular lights.

use crate::support::{Picture, Shot, assert_profile, material, over_pixel, rectangle, vector};

/// A camera that looks down on the floor from a height of 0.9, below all objects that cast shadows.
/// The view reaches 0.9 to each side.
fn from_above() -> Shot {
    Shot {
        from: vec![[0.0, 0.0, 0.9]],
        to: vec![[0.0; 3]],
        sky: [0.0, 1.0, 0.0],
        fov: 1.0,
        ..Shot::default()
    }
}

fn horizontal(x: [f64; 2], y: [f64; 2], z: f64) -> [[f64; 3]; 3] {
    [[x[0], y[0], z], [x[1], y[0], z], [x[1], y[1], z]]
}

fn floor() -> String {
    material("paper", "diffuse { 1 1 1 }")
        + &rectangle("floor", "paper", horizontal([-50.0, 50.0], [-50.0, 50.0], 0.0), "")
}

/// A lid over the left half of the floor, at height 1.
fn lid() -> String {
    rectangle("lid", "paper", horizontal([-50.0, 0.0], [-50.0, 50.0], 1.0), "")
}

/// A square light of side 0.5 at height 2, above the edge of the lid.
fn lamp() -> String {
    let [a, b, c] = horizontal([-0.25, 0.25], [-0.25, 0.25], 2.0).map(vector);
    format!("light_rectangle lamp {{ color {{ 1 1 1 }} vertex0 {a} vertex1 {b} vertex2 {c} }}\n")
}

/// Light at (x, y) of the floor: the mean of the cosine over the lamp, counting the points of the
/// lamp for which `sees` is true.
fn lit(x: f64, y: f64, sees: impl Fn(f64) -> bool) -> f64 {
    let steps = 16;
    let place = |k: u32| ((f64::from(k) + 0.5) / f64::from(steps) - 0.5) * 0.5;
    let mut sum = 0.0;
    for k in 0..steps * steps {
        let [lamp_x, lamp_y] = [place(k % steps), place(k / steps)];
        if sees(lamp_x) {
            let [dx, dy] = [lamp_x - x, lamp_y - y];
            sum += 2.0 / (dx * dx + dy * dy + 4.0).sqrt();
        }
    }
    sum / f64::from(steps * steps)
}

/// Expected mean of rows 28 to 35 of the floor.
fn profile(sees: impl Fn(f64, f64) -> bool) -> Vec<f64> {
    let column = |x: usize| {
        let rows = (28..36).map(|y| {
            over_pixel(x, y, |u, v| lit(0.9 * u, 0.9 * v, |lamp_x| sees(0.9 * u, lamp_x)))
        });
        rows.sum::<f64>() / 8.0
    };
    (0..64).map(column).collect()
}

fn found(picture: &Picture) -> Vec<f64> {
    picture.columns(28..36, 0)
}

#[test]
fn a_rectangle_lights_the_floor_by_the_cosine_alone() {
    let picture = from_above().take(&(floor() + &lamp()));
    assert_profile(&found(&picture), &profile(|_, _| true), 2e-3);
}

#[test]
fn a_wide_lamp_at_a_slant_does_not_shade_itself() {
    // The lamp is 16 units wide and only 0.9 above the floor, as high as the camera. Coordinates
    // relative to the camera are 0 along the lamp's normal, and roundings along the rays are
    // proportional to the lamp's width.
    let [a, b, c] = horizontal([-8.0, 8.0], [-8.0, 8.0], 0.9).map(vector);
    let lamp =
        format!("light_rectangle lamp {{ color {{ 1 1 1 }} vertex0 {a} vertex1 {b} vertex2 {c} }}");
    let picture = Shot { samples: 256, ..from_above() }.take(&(floor() + &lamp));
    let place = |k: u32| ((f64::from(k) + 0.5) / 256.0 - 0.5) * 16.0;
    let points =
        (0..256).flat_map(|i| (0..256).map(move |k| place(i) * place(i) + place(k) * place(k)));
    let expected = points.map(|d2| 0.9 / (d2 + 0.81).sqrt()).sum::<f64>() / 65536.0;
    let found = (28..36).map(|y| picture.row(y, 0)[28..36].iter().sum::<f64>()).sum::<f64>() / 64.0;
    assert!((found / expected - 1.0).abs() < 5e-3, "{found}, expected {expected}");
}

#[test]
fn penumbra_of_an_edge() {
    // The line from (x, 0) to a point (lx, 2) of the lamp passes height 1 at (x + lx) / 2. It
    // misses the lid if that is positive. The penumbra is as wide as the lamp, since the lid is
    // half way.
    let shot = Shot { settings: "softShadowSamples 4".into(), ..from_above() };
    let picture = shot.take(&(floor() + &lamp() + &lid()));
    assert_profile(&found(&picture), &profile(|x, lamp_x| x + lamp_x > 0.0), 0.01);
    for y in 0..64 {
        // Umbra up to x = -0.25: column 23.1.
        assert!((0..23).all(|x| picture.at(x, y)[0] == 0.0));
        assert!(picture.at(24, y)[0] > 0.0);
    }
}

#[test]
fn one_light_at_a_time_has_the_same_penumbra() {
    let dim = "light_point dim { color { 0 0 0 } position { 0 0 3 } }";
    let settings = "lightSamplingType SAMPLE_ONE_AT_TIME softShadowSamples 4".into();
    let shot = Shot { settings, ..from_above() };
    let picture = shot.take(&(floor() + &lamp() + &lid() + dim));
    assert_profile(&found(&picture), &profile(|x, lamp_x| x + lamp_x > 0.0), 0.03);
}

#[test]
fn a_lamp_throws_a_shadow_but_not_on_its_own_light() {
    // A point light straight above the lamp. The lamp shades a square of side 0.5 * 4 / (4 - 2) = 1
    // on the floor, in the light of the point alone.
    let point = "light_point point { color { 1 1 1 } position { 0 0 4 } }";
    let picture = from_above().take(&(floor() + &lamp() + point));
    let expected = |x: f64, y: f64| {
        let shaded = x.abs() < 0.5 && y.abs() < 0.5;
        let cosine = 4.0 / (x * x + y * y + 16.0).sqrt();
        lit(x, y, |_| true) + if shaded { 0.0 } else { cosine }
    };
    let pixels = [(32, 32), (20, 40), (45, 45), (10, 32), (32, 60), (60, 3), (54, 31)];
    for (x, y) in pixels {
        let expected = over_pixel(x, y, |u, v| expected(0.9 * u, 0.9 * v));
        assert!((picture.at(x, y)[0] - expected).abs() < 4e-3, "{x} {y}");
    }
}

#[test]
fn a_shadow_of_a_point_light_is_sharp_and_black() {
    // From (0.3, 0, 2) past the edge (0, y, 1) to (-0.3, y, 0): column 21.33.
    let point = "light_point point { color { 1 1 1 } position { 0.3 0 2 } }";
    let picture = from_above().take(&(floor() + &lid() + point));
    for y in 0..64 {
        assert!((0..21).all(|x| picture.at(x, y)[0] == 0.0));
        assert!((22..64).all(|x| picture.at(x, y)[0] > 0.5));
    }
    let lit = |x: f64, y: f64| 2.0 / ((x - 0.3) * (x - 0.3) + y * y + 4.0).sqrt();
    let expected = lit(-0.3, 0.0) * 2.0 / 3.0;
    assert!((picture.at(21, 32)[0] - expected).abs() < 0.02, "{:?}", picture.at(21, 32));
}

#[test]
fn a_refractive_lid_blocks_light_unless_shadows_are_transparent() {
    let glass = material("glass", "refraction 0.75 refraction_index 1.5")
        + &rectangle("lid", "glass", horizontal([-50.0, 50.0], [-50.0, 50.0], 1.0), "");
    let point = "light_point point { color { 1 1 1 } position { 0 0 2 } }";
    let scene = floor() + &glass + point;
    from_above().take(&scene).assert_is([0.0; 3], 0.0);
    let shot = Shot { settings: "shadow TRANSPARENT".into(), ..from_above() };
    let picture = shot.take(&scene);
    for (x, y) in [(32, 32), (5, 60), (50, 10)] {
        let lit = |u: f64, v: f64| 0.75 * 2.0 / (0.81 * (u * u + v * v) + 4.0).sqrt();
        assert!((picture.at(x, y)[0] - over_pixel(x, y, lit)).abs() < 1e-3);
    }
}
