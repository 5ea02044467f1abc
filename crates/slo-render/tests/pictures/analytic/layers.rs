//! Layers of albedo and normals, tested on surfaces whose shares are known.

use crate::support::{Shot, glow, material, panel, pivot_at, rectangle};

/// A wall that fills the view, with nothing behind it.
fn wall(phong: &str) -> String {
    material("wall", phong) + &panel("wall", "wall", [-90.0, 90.0], 0.0, [-90.0, 90.0])
}

/// A wall that deflects rays to the left, and a blue wall there with normal x.
fn corner(phong: &str) -> String {
    material("turn", phong)
        + &material("side", "diffuse { 0.1 0.2 0.8 }")
        + &rectangle("turn", "turn", [[9.0, -9.0, -9.0], [-9.0, 9.0, -9.0], [-9.0, 9.0, 9.0]], "")
        + &rectangle(
            "side",
            "side",
            [[-9.0, -90.0, -90.0], [-9.0, 90.0, -90.0], [-9.0, 90.0, 90.0]],
            "",
        )
}

#[track_caller]
fn check(shot: &Shot, elements: &str, albedo: [f64; 3], normal: [f64; 3]) {
    let [_, albedos, normals] = shot.take_layers(elements);
    albedos.assert_is(albedo, 1e-6);
    normals.assert_is(normal, 1e-6);
}

/// A view so narrow that all pixels show the same point.
fn narrow() -> Shot {
    Shot { fov: 0.01, samples: 2, ..Shot::default() }
}

#[test]
fn a_matte_surface_is_its_colour_whatever_the_light() {
    let wall = wall("ambient { 0.1 0.1 0 } diffuse { 0.5 0.25 1.5 } specular { 1 1 1 }");
    let lamp = "light_point lamp { color { 9 9 9 } position { 0 -5 0 } }";
    for elements in [wall.clone(), wall + lamp] {
        check(&Shot::default(), &elements, [0.6, 0.35, 1.0], [0.0, -1.0, 0.0]);
    }
}

#[test]
fn a_mirror_shows_the_layers_of_what_it_mirrors() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let mirror = corner("diffuse { 0.1 0.1 0.1 } reflectance 0.75");
    let normal = [0.75 - 0.25 * half, -0.25 * half, 0.0];
    check(&narrow(), &mirror, [0.175, 0.25, 0.7], normal);
    // Without a bounce the layers are empty, like the picture.
    let flat = Shot { recursion: 0, ..narrow() };
    check(&flat, &mirror, [0.1; 3], [-0.25 * half, -0.25 * half, 0.0]);
}

#[test]
fn a_rough_mirror_is_a_surface_of_its_own() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let settings = "diffuseReflectionSamples 3".to_owned();
    for shot in [narrow(), Shot { settings, ..narrow() }, Shot { recursion: 0, ..narrow() }] {
        let rough = corner("diffuse { 0.1 0.1 0.1 } reflectance 0.75 diffuse_reflection 0.1");
        check(&shot, &rough, [0.85; 3], [-half, -half, 0.0]);
    }
}

#[test]
fn clear_glass_shows_the_layers_of_what_is_behind() {
    let clear = material("clear", "refraction 0.5 refraction_index 1");
    let pane = panel("pane", "clear", [-90.0, 90.0], -1.0, [-90.0, 90.0]);
    let elements = clear.clone() + &pane + &wall("diffuse { 0.8 0.6 0.4 }");
    check(&narrow(), &elements, [0.4, 0.3, 0.2], [0.0, -1.0, 0.0]);
    // Surfaces behind a rough mirror do not count, whether clear glass is in between or not.
    let across = [[-5.0, -90.0, -90.0], [-5.0, 90.0, -90.0], [-5.0, 90.0, 90.0]];
    let turned = corner("reflectance 0.5 diffuse_reflection 0.01")
        + &clear
        + &rectangle("pane", "clear", across, "");
    let half = std::f64::consts::FRAC_1_SQRT_2;
    check(&narrow(), &turned, [0.5; 3], [-half, -half, 0.0]);
}

#[test]
fn lamps_and_the_background_have_no_normals() {
    let shot = Shot { settings: "background { 0.25 1 4 }".into(), ..Shot::default() };
    let far = panel("far", "far", [900.0, 901.0], 0.0, [0.0, 1.0]) + &glow("far", [1.0; 3]);
    check(&shot, &far, [0.25, 1.0, 1.0], [0.0; 3]);
    let lamp = far
        + "light_rectangle lamp { color { 0.5 3 0.5 }
             vertex0 { -90 0 -90 } vertex1 { 90 0 -90 } vertex2 { 90 0 90 } }";
    check(&shot, &lamp, [0.5, 1.0, 0.5], [0.0; 3]);
}

#[test]
fn lens_and_motion_blur_layers_as_they_blur_colours() {
    // A glowing surface has its displayed colour as albedo, and so does a mirror image of it in a
    // glowing surface.
    let moving = rectangle(
        "moving",
        "red",
        [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 0.0, 1.0]],
        &(pivot_at(0.0, [-2.0, 0.0, 1.0]) + &pivot_at(1.0, [1.0, -2.0, 1.0])),
    );
    let elements = glow("red", [0.5, 0.25, 0.125])
        + &material("floor", "ambient { 0.25 0.25 0.5 } reflectance 0.5")
        + "plane floor { material floor normal { 0 0 1 } position { 0 0 -1 } }"
        + &moving;
    let settings = "background { 0.125 0.25 0.5 }".to_owned();
    let shot = Shot { lens: 0.5, dof: 8.0, blur: 1.0, samples: 16, settings, ..Shot::default() };
    let [colors, albedo, normals] = shot.take_layers(&elements);
    let mut lengths = [false; 3];
    for (i, (color, albedo)) in colors.0.rgb.iter().zip(&albedo.0.rgb).enumerate() {
        for c in 0..3 {
            assert!((color[c] - albedo[c]).abs() < 1e-6, "{i}: {color:?} {albedo:?}");
        }
        let [x, y, z] = normals.0.rgb[i].map(f64::from);
        let length = (x * x + y * y + z * z).sqrt();
        lengths[0] |= length < 1e-6;
        lengths[1] |= length > 0.02 && length < 0.48;
        lengths[2] |= (length - 0.5).abs() < 1e-6;
        assert!(length < 1.0 + 1e-6);
    }
    assert_eq!(lengths, [true; 3], "sky, edges and the floor, half mirror, are all seen");
}
