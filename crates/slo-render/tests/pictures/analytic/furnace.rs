//! White furnace: if light of radiance 1 comes from everywhere and nothing is absorbed, every pixel
//! is 1, whatever the shape and the gloss. The part that the recursion cuts off is black.

use crate::support::{Shot, material};

/// One object in a world of light 1.
fn furnace(recursion: u32, samples: u32) -> Shot {
    let settings = "background { 1 1 1 }".to_owned();
    Shot { fov: 0.2, recursion, samples, settings, plain: true, ..Shot::default() }
}

const SPHERE: &str = "sphere s { material m center { 0 0 0 } radius 1.5 }";
const BOX: &str = "box b { material m vertex0 { -1 -1 -0.8 } vertex1 { 1 -0.6 -1 } \
    vertex2 { 0.6 1.4 -1 } height 1.5 }";
const CYLINDER: &str = "cylinder c { material m base { -1 0 0 } top { 1 1 1 } radius 1 }";
const CONE: &str = "cone c { material m base { -1 0 0 } apex { 1 1 1 } radius 1 }";
const MESH: &str = "mesh m { material m filename files/ball.obj smooth_normals 0 }";
const SMOOTH_MESH: &str = "mesh m { material m filename files/ball.obj smooth_normals 1 }";
const MOVING_SPHERE: &str = "sphere s { material m center { 0 0 0 } radius 1.5 \
    addKframe { time 0 key { pivot { -1 0 0 } } } addKframe { time 1 key { pivot { 1 0 0 } } } }";

const SHAPES: [&str; 7] = [SPHERE, BOX, CYLINDER, CONE, MESH, SMOOTH_MESH, MOVING_SPHERE];

#[test]
fn convex_mirrors_of_any_gloss_reflect_everything_at_once() {
    // A reflected ray cannot hit a convex object again, so one bounce must suffice. Light would be
    // lost if a ray hit the surface that it leaves, or passed below it.
    for shape in SHAPES {
        for sigma in [0.0, 0.1, 0.5, 1.0] {
            let mirror = material("m", &format!("reflectance 1 diffuse_reflection {sigma}"));
            let shot = Shot { blur: 1.0, ..furnace(1, 8) };
            shot.take(&(mirror + shape)).assert_is([1.0; 3], 1e-6);
        }
    }
}

#[test]
fn clear_spheres_pass_everything_in_two_bounces() {
    for index in [1.5, 1.0, 0.7] {
        // Rays that meet the thin sphere at a slant are totally reflected outside, in one bounce.
        let glass = material("m", &format!("refraction 1 refraction_index {index}"));
        furnace(2, 8).take(&(glass + SPHERE)).assert_is([1.0; 3], 1e-6);
    }
}

/// Material that reflects 0.4 and transmits 0.6, both with the same spread.
fn frosted(sigma: f64, more: &str) -> String {
    let phong = format!(
        "refraction 0.6 reflectance 0.4 refraction_index 1.5
         diffuse_refraction {sigma} diffuse_reflection {sigma} {more}"
    );
    material("m", &phong)
}

#[test]
fn frosted_things_keep_nothing() {
    // Total internal reflection keeps light inside for many bounces. Near the rim of a ball its
    // direction changes by about sigma at each bounce, and in a smooth mesh some directions never
    // escape. So the test does not check when light escapes, only that none is lost. With ambient
    // light of 1, every hit adds its weight. Subtracting the weights of all earlier hits leaves the
    // weights of the last hits, where the recursion ends. These and the light that escaped add up
    // to 1.
    let recursion = 24;
    for shape in SHAPES {
        for sigma in [0.0, 0.2, 1.0] {
            let scene = frosted(sigma, "ambient { 1 1 1 }") + shape;
            let all = Shot { blur: 1.0, ..furnace(recursion, 2) };
            let earlier = Shot { settings: String::new(), recursion: recursion - 1, ..all.clone() };
            let (all, earlier) = (all.take(&scene), earlier.take(&scene));
            for (i, (all, earlier)) in all.0.rgb.iter().zip(&earlier.0.rgb).enumerate() {
                let sum = all[0] - earlier[0];
                // At most 25 hits, with weights that are rounded 24 times by 2^-24.
                assert!((sum - 1.0).abs() < 5e-5, "{sum} in pixel {i} of {shape}, sigma {sigma}");
            }
        }
    }
}

#[test]
fn frosted_things_give_everything_back_in_the_end() {
    // With a cosine lobe, a ball, the worst shape, keeps 0.85 of the light inside at each bounce:
    // 1e-9 is left after 128 bounces.
    for shape in SHAPES {
        let shot = Shot { blur: 1.0, ..furnace(128, 1) };
        shot.take(&(frosted(1.0, "") + shape)).assert_is([1.0; 3], 1e-4);
    }
}

#[test]
fn many_samples_of_a_lobe_weigh_as_much_as_one() {
    let settings = "background { 1 1 1 } diffuseReflectionSamples 5 diffuseRefractionSamples 3";
    let phong = "refraction 0.5 reflectance 0.5 diffuse_refraction 0.2 diffuse_reflection 0.2";
    let shot = Shot { settings: settings.into(), ..furnace(20, 2) };
    shot.take(&(material("m", phong) + SPHERE)).assert_is([1.0; 3], 5e-3);
}

#[test]
fn a_bounce_too_few_is_black() {
    let glass = material("m", "refraction 1 refraction_index 1.5");
    let picture = furnace(1, 8).take(&(glass + SPHERE));
    assert_eq!(picture.at(32, 32), [0.0; 3]);
    assert_eq!(picture.at(0, 0), [1.0; 3]);
}
