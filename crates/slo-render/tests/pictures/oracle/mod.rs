//! Compares the renderer with the plainest renderer that follows docs/rendering.md: recursive, one
//! ray at a time, in f64, without any acceleration structure. Both use the same sample points, so
//! they differ only by rounding.

mod lamps;
mod light;
mod motion;
mod path;
mod paths;
mod points;
mod solid;
mod surface;
mod world;

use std::fs;
use std::path::Path;

use glam::DVec3;

use slo_accel::Isa;
use slo_scene::{Files, Integrator, LightKind, MaterialKind, SceneDescription, load};

use crate::support::{describe, expose, material};
use light::Oracle;
use path::PathOracle;

/// Largest difference of a channel caused by rounding.
///
/// Coordinates up to 10 have an error of 1e-6 in f32. A mirror of radius 1 deflects a ray by twice
/// that, over distances of about 3. A highlight of exponent 20 or the next mirror multiplies the
/// error by 6, and so on with each bounce, while the ray's weight falls. After two bounces, about
/// 1e-4 is left in the worst pixels.
const ROUNDING: f64 = 2e-4;

/// Limit of the differences of half of all pixels: a few roundings of the terms that are added up.
const MEDIAN: f64 = 2e-6;

/// Share of pixels in which a ray may pass an edge on the other side. About 10 edges cross the 100
/// rays of a pixel, each with a probability of 1e-6 to 1e-5 (the rounding, for each unit of space),
/// which affects one pixel in a picture of 384. Four would be a coincidence, or a mistake.
const AT_EDGES: f64 = 3.0 / 384.0;

const WIDTH: u32 = 24;
const HEIGHT: u32 = 16;

/// A scene of 24 x 16 pixels with 4 samples. Times 0 to 1 take a second, and the camera stands in
/// front of the origin.
fn scene(settings: &str, elements: &str) -> String {
    scene_seen("addPosition { 0 -9 1.5 } addTarget { 0 0 0.2 }", settings, elements)
}

fn scene_seen(segment: &str, settings: &str, elements: &str) -> String {
    format!(
        "settings s {{ imageSamples 4 background {{ .1 .2 .4 }} transformSamplesPerMs 4 {settings} }}
         Camera c {{
             fps 4
             Film f {{ width {WIDTH} height {HEIGHT} prefix test output PNG_IMAGE }}
             CamSegment seg {{ videoStart 0 videoEnd 2 sceneStart -1 sceneEnd 1 fovStart .35 {segment} }}
         }}
         {elements}"
    )
}

/// Differences of all pixels, in rising order.
fn differences(scene: &SceneDescription) -> Vec<f64> {
    let image = expose(scene, Isa::best()).image();
    let expected: Box<dyn Fn(u32, u32) -> DVec3> = match scene.settings.integrator {
        Integrator::PhotonMap => panic!("it traces no photons"),
        Integrator::Distributed => {
            let oracle = Oracle::new(scene, 0);
            Box::new(move |x, y| oracle.pixel(x, y))
        }
        Integrator::Path => {
            let oracle = PathOracle::new(scene, 0);
            Box::new(move |x, y| oracle.pixel(x, y))
        }
    };
    let mut differences: Vec<f64> = (0..WIDTH * HEIGHT)
        .map(|i| {
            let found = DVec3::from_array(image.rgb[i as usize].map(f64::from));
            (found - expected(i % WIDTH, i / WIDTH)).abs().max_element()
        })
        .collect();
    differences.sort_by(f64::total_cmp);
    differences
}

/// Differences of all pixels of the renderer's pictures of two scenes, in rising order.
fn differences_between(a: &SceneDescription, b: &SceneDescription) -> Vec<f64> {
    let [a, b] = [a, b].map(|scene| expose(scene, Isa::best()).image());
    let difference = |(a, b): (&[f32; 3], &[f32; 3])| {
        (0..3).map(|c| f64::from((a[c] - b[c]).abs())).fold(0.0, f64::max)
    };
    let mut all: Vec<f64> = a.rgb.iter().zip(&b.rgb).map(difference).collect();
    all.sort_by(f64::total_cmp);
    all
}

/// Whether sorted differences are explained by rounding.
fn agrees(differences: &[f64]) -> bool {
    let share = differences.iter().filter(|d| **d > ROUNDING).count() as f64;
    share <= AT_EDGES * differences.len() as f64 && differences[differences.len() / 2] <= MEDIAN
}

#[track_caller]
fn assert_agrees(text: &str) {
    let differences = differences(&describe(text));
    let largest = &differences[differences.len() - 12..];
    assert!(agrees(&differences), "{largest:.6?}\n{text}");
}

const LAMP: &str = "light_point lamp { color { .8 .7 .6 } position { 4 -6 6 } }\n";
const PANEL: &str = "light_rectangle panel { color { .5 .6 .7 }
    vertex0 { -4 -3 4 } vertex1 { -2 -3 5 } vertex2 { -2 -1 5 } }\n";
const STRIP: &str = "light_rectangle strip { color { .4 .2 .1 }
    vertex0 { 1 1 3.5 } vertex1 { 3 1 3.5 } vertex2 { 3 1.2 3.5 } }\n";
const FLOOR: &str = "phong_info plank { ambient { .1 .1 .1 } diffuse { .8 .8 .8 } }
    texture plank { filename files/plank.png }
    material_texture wood { phong_info plank texture plank scale_U 5 scale_V -3 }
    rectangle floor { material wood vertex0 { -6 -4 -1 } vertex1 { 6 -4 -1 } vertex2 { 6 6 -1 } }
    plane ground { material dull normal { 0 0 1 } position { 0 0 -1.5 } }\n";

/// One of each shape, with materials a to d.
const SHAPES: &str = "
    sphere s1 { material a center { -1.6 0 0 } radius 0.9 }
    mesh m1 { filename files/ball.obj smooth_normals 1 material b
        addKframe { time 0 key { pivot { 1.7 0.5 0.6 } up { 0 1 1 } } } }
    box b1 { material c vertex0 { -0.5 -1.5 -0.9 } vertex1 { 0.3 -1.8 -0.9 } vertex2 { 0.5 -1.2667 -0.9 } height 0.7 }
    cylinder c1 { material d base { 1.5 -2 -0.8 } top { 1.9 -2.2 0.1 } radius 0.4 }
    cone k1 { material d base { -2 -2.5 -0.8 } apex { -2 -2.4 0.4 } radius 0.5 }
    triangle t1 { material c vertex0 { -1 2 -0.5 } vertex1 { 1 2 -0.5 } vertex2 { 0 2.5 2 } }\n";

/// The shapes on the floor, with these materials.
fn shapes(phong: [&str; 4]) -> String {
    let materials: String =
        ["a", "b", "c", "d"].iter().zip(phong).map(|(name, phong)| material(name, phong)).collect();
    material("dull", "diffuse { .3 .4 .3 }") + &materials + FLOOR + SHAPES
}

const MATT: &str = "ambient { .05 .05 .1 } diffuse { .6 .3 .2 }";
const SHINY: &str = "diffuse { .2 .4 .3 } specular { .5 .5 .5 } shininess 20";
const MIRROR: &str = "diffuse { .2 .2 .2 } reflectance .6";
const BRUSHED: &str = "diffuse { .2 .1 .1 } reflectance .7 diffuse_reflection .2";
const GLASS: &str =
    "specular { .3 .3 .3 } shininess 0 reflectance .1 refraction .8 refraction_index 1.5";
const MILK: &str = "reflectance .2 refraction .7 refraction_index 1.3 diffuse_refraction .3
    diffuse_reflection 1";
const BUBBLE: &str = "reflectance .2 refraction .7 refraction_index .8";

#[test]
fn images_and_highlights_under_lamps() {
    let second = "light_point second { color { .2 .3 .2 } position { -5 2 7 } }";
    assert_agrees(&scene("", &(shapes([SHINY, SHINY, MATT, SHINY]) + LAMP + second)));
}

#[test]
fn soft_shadows_of_all_lights() {
    let all = shapes([MATT, SHINY, MIRROR, MATT]) + LAMP + PANEL + STRIP;
    assert_agrees(&scene("softShadowSamples 3", &all));
}

#[test]
fn soft_shadows_of_one_light_at_a_time() {
    let all = shapes([MATT, SHINY, MIRROR, MATT]) + LAMP + PANEL + STRIP;
    let settings = "lightSamplingType SAMPLE_ONE_AT_TIME softShadowSamples 3";
    assert_agrees(&scene(settings, &all));
}

#[test]
fn light_through_glass() {
    let pane = material("pane", "diffuse { .2 0 0 } refraction .6")
        + "rectangle pane { material pane vertex0 { 0 -3 1.4 } vertex1 { 3 -3 1.6 } vertex2 { 3 0 1.6 } }";
    let all = shapes([GLASS, MILK, BUBBLE, GLASS]) + LAMP + PANEL + &pane;
    assert_agrees(&scene("shadow TRANSPARENT recursion 2", &all));
    assert_agrees(&scene("shadow OPAQUE recursion 2", &all));
}

#[test]
fn mirrors_and_brushed_metal() {
    let all = shapes([MIRROR, MIRROR, BRUSHED, BRUSHED]) + LAMP + PANEL;
    assert_agrees(&scene("diffuseReflectionSamples 3", &all));
}

#[test]
fn glass_and_milk() {
    let all = shapes([GLASS, MILK, MILK, BUBBLE]) + LAMP + STRIP;
    assert_agrees(&scene(
        "diffuseRefractionSamples 2 diffuseReflectionSamples 3 recursion 4",
        &all,
    ));
}

#[test]
fn every_recursion_ends_where_it_should() {
    for recursion in [0, 1, 2, 5] {
        let all = shapes([GLASS, GLASS, BRUSHED, MIRROR]) + LAMP + PANEL;
        assert_agrees(&scene(&format!("recursion {recursion}"), &all));
    }
}

/// Objects that turn, fly along curves and rest, one of them with an image.
const MOVING: &str = "
    sphere globe { material wood center { 0 0 0 } radius 0.5
        addKframe { time -2 key { pivot { -1 -3 0 } right { 1 0 0 } } nex { pivot { 0 -4 3 } right { 1 1 0 } } }
        addKframe { time -0.8 pre { pivot { 2 -3 0 } } key { pivot { 1 -3 0.5 } right { 0 1 1 } up { 1 0 0 } } }
        addKframe { time 3 key { pivot { 2 -2 0 } up { 1 1 0 } } } }
    box dice { material c vertex0 { -.3 -.3 -.3 } vertex1 { .3 -.3 -.3 } vertex2 { .3 .3 -.3 } height .6
        addKframe { time -1 key { pivot { 0 -2 1 } } } addKframe { time 0 key { right { 1 1 .5 } pivot { .4 -2 1.3 } } } }
    mesh ball { filename files/tetrahedron.slo material b
        addKframe { time -3 key { pivot { -2.5 -1 1 } } } addKframe { time -2 key { pivot { -1.5 -1 1 } } } }\n";

#[test]
fn things_that_move() {
    let all = shapes([MATT, BRUSHED, MIRROR, SHINY]) + MOVING + LAMP + PANEL;
    let still = "addPosition { 0 -9 1.5 } addTarget { 0 0 0.2 } blurDuration 1";
    assert_agrees(&scene_seen(still, "", &all));
}

/// A camera that moves, turns and zooms, with an open lens and an open shutter.
const FLIGHT: &str = "addPosition { -1 -9 1 } addPosition { 0 -8 4 } addPosition { 2 -9 1 }
    addTarget { 0 0 0 } addTarget { .5 0 .5 } skyStart { 0 0 1 } skyEnd { .3 0 1 }
    fovEnd .3 lensRadiusStart .1 lensRadiusEnd .3 dofStart 8 dofEnd 10 blurDuration 3";

#[test]
fn a_camera_that_moves_with_an_open_lens() {
    let all = shapes([SHINY, MATT, MIRROR, SHINY]) + LAMP + PANEL;
    assert_agrees(&scene_seen(FLIGHT, "dofSamples 2", &all));
}

fn everything(settings: &str) -> String {
    let all = shapes([GLASS, MIRROR, BRUSHED, MILK]) + MOVING + LAMP + PANEL + STRIP;
    let settings = format!(
        "recursion 3 shadow TRANSPARENT softShadowSamples 2 diffuseReflectionSamples 2
         diffuseRefractionSamples 2 {settings}"
    );
    scene_seen(FLIGHT, &settings, &all)
}

#[test]
fn everything_at_once_by_every_generator() {
    for generator in ["PSEUDO", "ZERO_TWO", "QUASI"] {
        for lights in ["SAMPLE_ONE_AT_TIME", "SAMPLE_ALL_AT_TIME"] {
            assert_agrees(&everything(&format!(
                "generatorType {generator} lightSamplingType {lights} seed 5"
            )));
        }
    }
}

#[test]
fn shipped_scenes() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let folder = root.join("scenes");
    // The others have 10000 triangles and more, and the oracle tests each of them.
    for name in ["thesis2011.txt", "motion_blur.txt"] {
        let text = fs::read_to_string(folder.join(name)).unwrap();
        let loaded = load(name, &text, &Files::on_disk(&folder, &root, true));
        let mut scene = loaded.scene.unwrap_or_else(|| panic!("{:#?}", loaded.diagnostics));
        (scene.camera.film.width, scene.camera.film.height) = (WIDTH, HEIGHT);
        (scene.settings.image_samples, scene.settings.image_min_samples) = (1, 1);
        scene.settings.dof_samples = 1;
        let differences = differences(&scene);
        let largest = &differences[differences.len() - 12..];
        assert!(agrees(&differences), "{largest:.6?} in {name}");
    }
}

#[test]
fn the_comparison_finds_small_mistakes() {
    let right = describe(&everything(""));
    let changes: [fn(&mut SceneDescription); 4] = [
        |scene| scene.settings.seed = 1,
        |scene| scene.settings.recursion = Some(2),
        |scene| match &mut scene.lights[1].kind {
            LightKind::Point(light) => light.color[0] *= 1.02,
            LightKind::Rectangle(light) => light.color[0] *= 1.02,
            other => panic!("no light of the thesis: {other:?}"),
        },
        |scene| match &mut scene.materials[3].kind {
            MaterialKind::Phong(phong) => phong.info.diffuse_reflection *= 1.02,
            other => panic!("no Phong material: {other:?}"),
        },
    ];
    for (number, change) in changes.into_iter().enumerate() {
        let mut wrong = right.clone();
        change(&mut wrong);
        assert!(!agrees(&differences_between(&right, &wrong)), "change {number}");
    }
}
