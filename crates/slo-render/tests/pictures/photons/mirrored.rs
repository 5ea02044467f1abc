//! The caustic of a plane mirror is the light of the mirrored lamp.

use crate::support::{Picture, Shot};

/// A surface without gloss.
const MATTE: &str =
    "material_principled matte { base_color { .6 .6 .6 } ior 1 specular_ior_level 0 } ";
const MIRROR: &str = "material_principled mirror { base_color { 1 1 1 } metallic 1 roughness 0 } ";

const FLOOR: &str = "rectangle floor { material matte vertex0 { -1.2 -3 0 } vertex1 { 4 -3 0 } vertex2 { 4 3 0 } } ";

const SCREEN: &str = "material_principled black { base_color { 0 0 0 } ior 1 specular_ior_level 0 }
    rectangle screen { material black vertex0 { -1.5 -9 0 } vertex1 { -1.5 9 0 } vertex2 { -1.5 9 2.2 } } ";

/// A ceiling at height 4 that is large enough for everything that the camera sees.
const CEILING: &str = "rectangle ceiling { material mirror vertex0 { -4 -2 4 } vertex1 { .5 -2 4 } vertex2 { .5 2 4 } } ";

fn shot(photons: f64, samples: u32, more: &str) -> Shot {
    Shot {
        from: vec![[1.0, -1.5, 3.0]],
        to: vec![[1.0, 0.0, 0.0]],
        fov: 0.35,
        recursion: 1,
        samples,
        settings: format!("integrator PATH photons {photons} {more}"),
        ..Shot::default()
    }
}

/// The mean of each quarter of a picture, of the red channel.
fn quarters(picture: &Picture) -> [f64; 4] {
    std::array::from_fn(|k| {
        let (x0, y0) = (32 * (k % 2), 32 * (k / 2));
        let pixels = (0..1024).map(|i| picture.at(x0 + i % 32, y0 + i / 32)[0]);
        pixels.sum::<f64>() / 1024.0
    })
}

/// Compares the means, and the quarters to four times the tolerance, since they are noisier.
#[track_caller]
fn assert_same(found: [f64; 4], expected: [f64; 4], tolerance: f64, what: &str) {
    let is_near = |a: f64, b: f64, tolerance: f64| (a / b - 1.0).abs() < tolerance;
    let quarters = (0..4).all(|k| is_near(found[k], expected[k], 4.0 * tolerance));
    let mean = is_near(found.iter().sum(), expected.iter().sum(), tolerance);
    assert!(mean && quarters, "{what}\n{found:?}, expected\n{expected:?}");
}

/// Lamps below the ceiling, and their images above it.
const LAMPS: [(&str, &str); 7] = [
    (
        "lamp_point l { power { 400 9 9 } position { -3 0 1.5 } }",
        "lamp_point l { power { 400 9 9 } position { -3 0 6.5 } }",
    ),
    (
        "lamp_point l { power { 400 9 9 } position { -3 0 1.5 } radius .4 }",
        "lamp_point l { power { 400 9 9 } position { -3 0 6.5 } radius .4 }",
    ),
    (
        "lamp_disc l { radiance { 50 9 9 } center { -3 0 1.5 } normal { .3 0 1 } radius .4 }",
        "lamp_disc l { radiance { 50 9 9 } center { -3 0 6.5 } normal { .3 0 -1 } radius .4 }",
    ),
    (
        "lamp_rectangle l { radiance { 50 9 9 }
            vertex0 { -3.3 -.4 1.5 } vertex1 { -2.7 -.4 1.5 } vertex2 { -2.7 .4 1.5 } }",
        "lamp_rectangle l { radiance { 50 9 9 }
            vertex0 { -3.3 -.4 6.5 } vertex1 { -3.3 .4 6.5 } vertex2 { -2.7 .4 6.5 } }",
    ),
    (
        "lamp_spot l { power { 400 9 9 } position { -3 0 1.5 } target { -1.6 .3 4 } angle_deg 50 blend .5 }",
        "lamp_spot l { power { 400 9 9 } position { -3 0 6.5 } target { -1.6 .3 4 } angle_deg 50 blend .5 }",
    ),
    (
        "lamp_sun l { irradiance { 9 2 2 } direction { .6 0 .8 } angle_deg 0 }",
        "lamp_sun l { irradiance { 9 2 2 } direction { .6 0 -.8 } angle_deg 0 }",
    ),
    (
        "lamp_sun l { irradiance { 9 2 2 } direction { .6 0 .8 } angle_deg .5 }",
        "lamp_sun l { irradiance { 9 2 2 } direction { .6 0 -.8 } angle_deg .5 }",
    ),
];

/// What keeps a lamp's own light from the floor.
fn screen(lamp: &str) -> &'static str {
    // The sun shines from below, past the floor.
    if lamp.starts_with("lamp_sun") { "" } else { SCREEN }
}

#[test]
fn the_caustic_of_a_mirror_is_the_light_of_the_mirrored_lamp() {
    for (lamp, image) in LAMPS {
        let common = MATTE.to_owned() + FLOOR + screen(lamp);
        let mirrored = MIRROR.to_owned() + CEILING + lamp;
        let expected = quarters(&shot(0.0, 64, "").take(&(common.clone() + image)));
        let found = quarters(&shot(40.0, 16, "").take(&(common.clone() + &mirrored)));
        assert_same(found, expected, 0.015, lamp);
        // Without photons, lamps that no ray can hit leave the floor dark.
        if !lamp.contains("radi") {
            let paths = shot(0.0, 16, "").take(&(common + &mirrored));
            assert_eq!(quarters(&paths), [0.0; 4], "{lamp}");
        }
    }
}

#[test]
fn a_body_that_glows_shines_from_the_mirror() {
    let cube = |z: f64| {
        format!(
            "material_principled glow {{ base_color {{ 0 0 0 }} ior 1 specular_ior_level 0
                emission_strength 20 }}
             box cube {{ material glow vertex0 {{ -3.3 -.3 {z} }} vertex1 {{ -2.7 -.3 {z} }}
                vertex2 {{ -2.7 .3 {z} }} height .6 }}"
        )
    };
    let common = MATTE.to_owned() + FLOOR + SCREEN;
    let expected = quarters(&shot(0.0, 64, "").take(&(common.clone() + &cube(6.2))));
    for settings in ["", "lightSamplingType SAMPLE_ALL_AT_TIME softShadowSamples 2"] {
        let scene = common.clone() + MIRROR + CEILING + &cube(1.2);
        let found = quarters(&shot(40.0, 16, settings).take(&scene));
        assert_same(found, expected, 0.015, settings);
    }
}

#[test]
fn a_mirror_under_an_even_sky_does_not_show() {
    // A floor point sees the sky or, in the wall of mirror, the sky again: the irradiance is pi.
    let wall = "rectangle wall { material mirror vertex0 { -.8 -3 0 } vertex1 { -.8 3 0 } vertex2 { -.8 3 5 } } ";
    for sky in ["environment e { radiance { 1 1 1 } }", "background { 1 1 1 } "] {
        let is_lamp = sky.starts_with("environment");
        let (lamp, background) = if is_lamp { (sky, "") } else { ("", sky) };
        let scene = [MATTE, MIRROR, FLOOR, wall, lamp].concat();
        let found = quarters(&shot(4.0, 64, background).take(&scene));
        assert_same(found, [0.6; 4], 0.004, sky);
    }
}

#[test]
fn groups_of_lamps_keep_their_own_photons() {
    let group = |lamp: &str, name: &str, at: &str| {
        format!("lamp_{lamp} {name} {{ {at} light_group {name} }} ")
    };
    let first = group("point", "a", "power { 400 9 9 } position { -3 0 1.5 }");
    let second = group(
        "disc",
        "b",
        "radiance { 450 9 9 } center { -3.5 .5 1.5 } normal { 0 0 1 } radius .3",
    );
    let scene = [MATTE, MIRROR, FLOOR, CEILING, SCREEN, &first, &second].concat();
    let [all, a, b] = shot(30.0, 12, "").take_groups(&scene);
    let alone = |lamp: &str| {
        let scene = [MATTE, MIRROR, FLOOR, CEILING, SCREEN, lamp].concat();
        quarters(&shot(30.0, 12, "").take(&scene))
    };
    assert_same(quarters(&a), alone(&first), 0.02, "a");
    assert_same(quarters(&b), alone(&second), 0.02, "b");
    let (all, sum) = (quarters(&all), [quarters(&a), quarters(&b)]);
    assert_same(all, std::array::from_fn(|k| sum[0][k] + sum[1][k]), 1e-5, "sum");
}

#[test]
fn errors_fall_with_the_number_of_passes() {
    let lamp = LAMPS[0];
    let common = MATTE.to_owned() + FLOOR + SCREEN;
    let expected = shot(0.0, 64, "").take(&(common.clone() + lamp.1));
    let error = |samples: u32| {
        let found = shot(1.0, samples, "").take(&(common.clone() + MIRROR + CEILING + lamp.0));
        let off = found.0.rgb.iter().zip(&expected.0.rgb).map(|(a, b)| f64::from(a[0] - b[0]));
        off.map(|off| off * off).sum::<f64>()
    };
    // Radii shrink such that squares of errors fall with the power -2/3 of the number of passes.
    let [first, middle, last] = [4, 16, 64].map(error);
    let slopes = [first / middle, middle / last].map(|ratio| libm::log(ratio) / libm::log(4.0));
    assert!(slopes.iter().all(|slope| (0.55..1.05).contains(slope)), "{slopes:?}");
}
