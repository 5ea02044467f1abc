//! Mirrors: the position and brightness of the image, and the number of bounces.

use crate::support::{Shot, assert_profile, glow, material, panel, rectangle};

#[test]
fn a_slanted_mirror_shows_the_image_behind_it() {
    // The mirror x + y = 0 maps (x, y) to (-y, -x). The panel at x = -8, y in 0.3..2.1 appears at y
    // = 8, 18 from the camera, x in -2.1..-0.3. A pixel is 18 / 64 there.
    let scene = glow("white", [1.0; 3])
        + &material("mirror", "reflectance 0.75")
        + &rectangle(
            "glass",
            "mirror",
            [[9.0, -9.0, -9.0], [-9.0, 9.0, -9.0], [-9.0, 9.0, 9.0]],
            "",
        )
        + &rectangle("p", "white", [[-8.0, 0.3, -1.5], [-8.0, 2.1, -1.5], [-8.0, 2.1, 3.0]], "");
    let picture = Shot::default().take(&scene);
    let px = 18.0 * 0.5 / 32.0;
    let bar = |from: f64, to: f64| -> Vec<f64> {
        (0..64)
            .map(|k| {
                let [left, right] = [from.max(k as f64), to.min(k as f64 + 1.0)];
                0.75 * (right - left).max(0.0)
            })
            .collect()
    };
    let columns = picture.columns(24..36, 0);
    assert_profile(&columns, &bar(32.0 - 2.1 / px, 32.0 - 0.3 / px), 5e-3);
    let middle: Vec<f64> = (0..64).map(|y| picture.at(28, y)[0]).collect();
    assert_profile(&middle, &bar(32.0 - 3.0 / px, 32.0 + 1.5 / px), 0.02);
}

#[test]
fn recursion_counts_bounces_after_the_first_hit() {
    // Between two mirrors. The front one adds 0.3 of its own and half of what it reflects; the back
    // one adds 0.7 and a quarter.
    let wall = |name: &str, y: f64| panel(name, name, [-1e3, 1e3], y, [-1e3, 1e3]);
    let scene = material("front", "ambient { 0.3 0.3 0.3 } reflectance 0.5")
        + &material("back", "ambient { 0.7 0.7 0.7 } reflectance 0.25")
        + &wall("front", 0.0)
        + &wall("back", -20.0);
    let (mut expected, mut weight) = (0.0, 1.0);
    for recursion in 0..7 {
        let (own, reflectance) = if recursion % 2 == 0 { (0.3, 0.5) } else { (0.7, 0.25) };
        expected += weight * own;
        weight *= reflectance;
        let shot = Shot { recursion, samples: 1, plain: true, ..Shot::default() };
        shot.take(&scene).assert_is([expected; 3], 1e-6);
    }
}

#[test]
fn the_background_is_mirrored_too() {
    let scene = material("mirror", "reflectance 0.5")
        + &panel("glass", "mirror", [-90.0, 90.0], 0.0, [-90.0, 90.0]);
    let settings = "background { 0.5 1 4 }".to_owned();
    let shot = Shot { settings, samples: 1, ..Shot::default() };
    shot.take(&scene).assert_is([0.25, 0.5, 2.0], 1e-6);
    let flat = Shot { recursion: 0, ..shot };
    flat.take(&scene).assert_is([0.0; 3], 0.0);
}

#[test]
fn a_glossy_mirror_spreads_a_line_by_its_lobe() {
    // Parallel rays (a view of 0.0005 to each side) meet a mirror that reflects them back, spread
    // by a lobe of density proportional to cos^n, n = 1 / sigma^2. Behind the camera, a wall glows
    // on one side of a plane through the axis at angle a from it, and so measures how much of the
    // lobe lies beyond that angle. For a cone, the share of directions farther from the axis than a
    // is cos^(n+1) a.
    for sigma in [0.1, 0.3, 1.0] {
        let n = 1.0 / (sigma * sigma);
        let a = sigma * 0.8;
        let radius = 40.0 * libm::tan(a);
        // The whole wall glows except a disc of this radius, 40 behind the mirror's face.
        let scene = material("mirror", &format!("reflectance 1 diffuse_reflection {sigma}"))
            + &panel("glass", "mirror", [-9.0, 9.0], 0.0, [-9.0, 9.0])
            + &glow("black", [0.0; 3])
            + &format!(
                "cylinder disc {{ material black base {{ 0 -41 0 }} top {{ 0 -40 0 }} radius {radius} }}"
            );
        let settings = "background { 1 1 1 }".to_owned();
        let shot = Shot { fov: 5e-4, settings, ..Shot::default() };
        let picture = shot.take(&scene);
        let mean = picture.sum(0) / 4096.0;
        let expected = libm::pow(libm::cos(a), n + 1.0);
        assert!((mean - expected).abs() < 4e-3, "sigma {sigma}: {mean}, expected {expected}");
    }
}
