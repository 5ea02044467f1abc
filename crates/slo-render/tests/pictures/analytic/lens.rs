//! Depth of field. A thin lens of radius c, focused at distance F, spreads a point at distance z
//! over a disc of radius c |1/z - 1/F| (at distance 1); times 32 / fov, that is in pixels.

use crate::support::{Shot, assert_profile, glow, panel};

/// Share of the unit disc to the left of `t`.
fn disc_left_of(t: f64) -> f64 {
    let t = t.clamp(-1.0, 1.0);
    0.5 + (t * (1.0 - t * t).sqrt() + libm::asin(t)) / std::f64::consts::PI
}

fn blur_radius_px(shot: &Shot, distance: f64) -> f64 {
    shot.lens * (1.0 / distance - 1.0 / shot.dof).abs() * 32.0 / shot.fov
}

/// A surface at depth `y` that fills the right half of the picture with light.
fn half_plane(y: f64) -> String {
    glow("white", [1.0; 3]) + &panel("half", "white", [0.0, 100.0], y, [-100.0, 100.0])
}

/// Row of a picture with an edge in its middle, blurred by a disc of this radius.
fn blurred_edge(radius_px: f64) -> Vec<f64> {
    let column = |x: usize| {
        let steps = (0..100).map(|k| (x as f64 - 32.0 + (k as f64 + 0.5) / 100.0) / radius_px);
        steps.map(disc_left_of).sum::<f64>() / 100.0
    };
    (0..64).map(column).collect()
}

#[test]
fn a_defocused_edge_has_the_profile_of_the_disc_of_confusion() {
    // (distance, lens radius, radius of the disc in pixels)
    for (distance, lens, radius) in [(5.0, 2.0, 12.8), (20.0, 3.0, 9.6), (8.0, 2.0, 3.2)] {
        let shot = Shot { lens, samples: 64, ..Shot::default() };
        assert!((blur_radius_px(&shot, distance) - radius).abs() < 1e-12);
        let found = shot.take(&half_plane(distance - 10.0)).columns(0..64, 0);
        assert_profile(&found, &blurred_edge(radius), 0.01);
    }
}

#[test]
fn what_lies_in_the_sharp_plane_is_sharp() {
    let shot = Shot { lens: 3.0, ..Shot::default() };
    let found = shot.take(&half_plane(0.0)).columns(0..64, 0);
    let expected: Vec<f64> = (0..64).map(|x| if x < 32 { 0.0 } else { 1.0 }).collect();
    assert_profile(&found, &expected, 2e-3);
}

#[test]
fn lens_samples_multiply_image_samples() {
    let shot = Shot { lens: 2.0, samples: 8, settings: "dofSamples 8".into(), ..Shot::default() };
    let found = shot.take(&half_plane(-5.0)).columns(0..64, 0);
    assert_profile(&found, &blurred_edge(12.8), 0.01);
}

#[test]
fn a_defocused_point_is_a_disc() {
    // A square of 4 pixels, spread over a disc of radius 12.8. Variances along an axis add up:
    // r^2/4 for a disc, a^2/12 for a square, 1/12 for a pixel. The total light is the light of the
    // square.
    let shot = Shot { lens: 2.0, samples: 256, ..Shot::default() };
    let (side, radius) = (4.0, 12.8);
    let half = side / 2.0 * 5.0 * shot.fov / 32.0;
    let scene =
        glow("white", [1.0; 3]) + &panel("point", "white", [-half, half], -5.0, [-half, half]);
    let picture = shot.take(&scene);
    assert!((picture.sum(0) / (side * side) - 1.0).abs() < 0.02, "{}", picture.sum(0));
    let moment = |of: &dyn Fn(f64, f64) -> f64| {
        let pixels = (0..64).flat_map(|y| (0..64).map(move |x| (x, y)));
        let weighted =
            pixels.map(|(x, y)| picture.at(x, y)[0] * of(x as f64 - 31.5, y as f64 - 31.5));
        weighted.sum::<f64>() / picture.sum(0)
    };
    let variance = radius * radius / 4.0 + side * side / 12.0 + 1.0 / 12.0;
    for axis in [moment(&|x, _| x * x), moment(&|_, y| y * y)] {
        assert!((axis / variance - 1.0).abs() < 0.03, "{axis}, expected {variance}");
    }
    for mean in [moment(&|x, _| x), moment(&|_, y| y), moment(&|x, y| x * y) / radius] {
        assert!(mean.abs() < 0.2, "{mean}");
    }
    // All of the disc, and nothing beyond it: the square reaches 2 sqrt 2 pixels from its middle.
    for (x, y) in (0..64).flat_map(|y| (0..64).map(move |x| (x, y))) {
        let distance = f64::hypot(x as f64 - 31.5, y as f64 - 31.5);
        if (distance - radius).abs() > 4.0 {
            assert_eq!(picture.at(x, y)[0] > 0.0, distance < radius, "{x} {y}");
        }
    }
}
