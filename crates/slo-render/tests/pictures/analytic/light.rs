//! The Phong terms, one by one.

use crate::support::{Shot, glow, material, over_pixel, panel, rectangle, vector};

#[test]
fn nothing_is_background() {
    let settings = "background { 0.25 0.5 3 }".to_owned();
    let shot = Shot { settings, ..Shot::default() };
    let behind =
        glow("white", [1.0; 3]) + &panel("behind", "white", [-1.0, 1.0], -30.0, [-1.0, 1.0]);
    shot.take(&behind).assert_is([0.25, 0.5, 3.0], 0.0);
}

#[test]
fn ambient_is_what_it_says() {
    let wall =
        glow("wall", [0.125, 0.5, 2.0]) + &panel("w", "wall", [-50.0, 50.0], 0.0, [-50.0, 50.0]);
    Shot::default().take(&wall).assert_is([0.125, 0.5, 2.0], 0.0);
    // A light does not change it.
    let lit = wall + "light_point lamp { color { 1 1 1 } position { 0 -5 0 } }";
    Shot::default().take(&lit).assert_is([0.125, 0.5, 2.0], 0.0);
}

#[test]
fn a_light_rectangle_shows_its_colour_from_both_sides() {
    let light = |y: f64| {
        let corners = [[-90.0, y, -90.0], [90.0, y, -90.0], [90.0, y, 90.0]].map(vector);
        format!(
            "light_rectangle l {{ color {{ 0.5 2 0.25 }} vertex0 {} vertex1 {} vertex2 {} }}",
            corners[0], corners[1], corners[2]
        )
    };
    Shot::default().take(&light(5.0)).assert_is([0.5, 2.0, 0.25], 0.0);
    let behind = Shot { to: vec![[0.0, -20.0, 0.0]], ..Shot::default() };
    behind.take(&light(-15.0)).assert_is([0.5, 2.0, 0.25], 0.0);
}

/// A wall at y = 0 with a lamp at (1, -4, 2) in front of it.
fn wall(phong: &str) -> String {
    material("wall", phong)
        + &panel("w", "wall", [-50.0, 50.0], 0.0, [-50.0, 50.0])
        + "light_point lamp { color { 0.5 1 2 } position { 1 -4 2 } }"
}

#[test]
fn diffuse_is_colour_times_light_times_cosine() {
    let picture = Shot::default().take(&wall("diffuse { 0.5 0.75 0.25 }"));
    for (x, y) in [(0, 0), (38, 19), (63, 63), (10, 50), (32, 32)] {
        let cosine = over_pixel(x, y, |u, v| {
            let [dx, dz] = [1.0 - 5.0 * u, 2.0 - 5.0 * v];
            4.0 / (dx * dx + dz * dz + 16.0).sqrt()
        });
        for (channel, factor) in [0.25, 0.75, 0.5].into_iter().enumerate() {
            let found = picture.at(x, y)[channel];
            assert!((found - factor * cosine).abs() < 1e-3, "{found} at {x} {y}");
        }
    }
}

#[test]
fn light_from_behind_does_not_light() {
    let scene = material("wall", "diffuse { 1 1 1 } specular { 1 1 1 } shininess 3")
        + &panel("w", "wall", [-50.0, 50.0], 0.0, [-50.0, 50.0])
        + "light_point lamp { color { 1 1 1 } position { 1 4 2 } }";
    Shot::default().take(&scene).assert_is([0.0; 3], 0.0);
}

#[test]
fn both_sides_of_a_wall_are_lit_alike() {
    // The same wall with the corners in reverse order.
    let corners = [[-50.0, 0.0, 50.0], [50.0, 0.0, 50.0], [50.0, 0.0, -50.0]];
    let phong = "diffuse { 0.5 0.75 0.25 } specular { 1 1 1 } shininess 9";
    let turned = material("wall", phong)
        + &rectangle("w", "wall", corners, "")
        + "light_point lamp { color { 0.5 1 2 } position { 1 -4 2 } }";
    let [a, b] = [wall(phong), turned].map(|scene| Shot::default().take(&scene));
    for (a, b) in a.0.rgb.iter().zip(&b.0.rgb) {
        assert!((0..3).all(|c| (a[c] - b[c]).abs() < 1e-5));
    }
}

#[test]
fn highlight_has_its_peak_and_width() {
    // Camera at (0, -4, 4) and lamp at (0, 4, 4) over the floor. The mirror direction meets the
    // camera at the origin, where the highlight is 1. It is half as bright where the angle between
    // E and R is acos(2^(-1/50)) = 9.5 degrees.
    let shot = Shot { from: vec![[0.0, -4.0, 4.0]], fov: 0.3, ..Shot::default() };
    let floor = [[-50.0, -50.0, 0.0], [50.0, -50.0, 0.0], [50.0, 50.0, 0.0]];
    let scene = material("floor", "specular { 1 0.5 0.25 } shininess 50")
        + &rectangle("f", "floor", floor, "")
        + "light_point lamp { color { 1 1 1 } position { 0 4 4 } }";
    let picture = shot.take(&scene);
    let highlight = |u: f64, v: f64| {
        // The ray of film point (u, v): D = (0, 1, -1) / sqrt 2, R = x, U = (0, 1, 1) / sqrt 2.
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let direction = glam::DVec3::new(0.3 * u, half + 0.3 * v * half, -half + 0.3 * v * half);
        let eye = glam::DVec3::new(0.0, -4.0, 4.0);
        let hit = eye + direction * (4.0 / -direction.z);
        let to_light = (glam::DVec3::new(0.0, 4.0, 4.0) - hit).normalize();
        let mirrored = glam::DVec3::new(-to_light.x, -to_light.y, to_light.z);
        libm::pow(mirrored.dot((eye - hit).normalize()).max(0.0), 50.0)
    };
    for y in (0..64).step_by(3) {
        for x in 0..64 {
            let expected = over_pixel(x, y, highlight);
            for (channel, factor) in [1.0, 0.5, 0.25].into_iter().enumerate() {
                let found = picture.at(x, y)[channel];
                assert!((found - expected * factor).abs() < 3e-3, "{found} at {x} {y}: {expected}");
            }
        }
    }
    let brightest =
        (0..64 * 64).max_by(|a, b| f32::total_cmp(&picture.0.rgb[*a][0], &picture.0.rgb[*b][0]));
    let (x, y) = brightest.map(|i| (i % 64, i / 64)).unwrap();
    assert!((31..=32).contains(&x) && (31..=32).contains(&y) && picture.at(x, y)[0] > 0.99);
    // along x the mirror direction turns by twice the angle under which ... is left to the profile
    let half_width = picture.row(32, 0).iter().filter(|v| **v > 0.5).count() as f64 / 2.0;
    let expected =
        (0..3200).find(|k| highlight(f64::from(*k) / 3200.0, -0.5 / 32.0) < 0.5).unwrap();
    assert!((half_width - f64::from(expected) / 100.0).abs() < 0.6, "{half_width}");
}
