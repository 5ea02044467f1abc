//! Light maps: the irradiance of objects by their texture coordinates, against formulas.

use std::f64::consts::PI;

use slo_accel::Isa;
use slo_picture::film::{Area, Film, Image};
use slo_render::frame::FrameScene;
use slo_render::render::{Observer, Plan, light_map, render};
use slo_scene::SceneDescription;

use crate::support::{Shot, describe, rectangle};

struct Unwatched;

impl Observer for Unwatched {
    fn advanced(&self, _share: f64) {}
}

fn scene(settings: &str, samples: u32, things: &str) -> SceneDescription {
    let settings = settings.to_owned();
    let shot = Shot { recursion: 16, samples, settings, blur: 0.5, ..Shot::default() };
    describe(&shot.of(things))
}

/// The light map of an object, made by `threads` threads.
fn bake_on(threads: usize, scene: &SceneDescription, object: &str, isa: Isa) -> Image {
    let number = scene.objects.iter().position(|of| of.name == object).unwrap();
    let side = scene.objects[number].light_map.unwrap().side;
    let built = FrameScene::build_light_map(scene, 0, number, isa, None);
    let frame = built.unwrap().expect("the object is shown");
    let plan = Plan::new(scene);
    let film = Film::new(Area::whole(side, side), plan.needs_spreads()).unwrap();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let exposed = pool.install(|| render(&frame, &plan, film, &Unwatched));
    assert!(exposed.is_complete);
    light_map(&frame, &exposed.film)
}

fn bake(scene: &SceneDescription, object: &str) -> Image {
    bake_on(2, scene, object, Isa::best())
}

/// Mean of a channel over the texels in some columns and rows.
fn mean(image: &Image, columns: std::ops::Range<usize>, rows: std::ops::Range<usize>) -> f64 {
    let at = |x: usize, y: usize| f64::from(image.rgb[y * image.width as usize + x][0]);
    let count = (columns.len() * rows.len()) as f64;
    rows.flat_map(|y| columns.clone().map(move |x| at(x, y))).sum::<f64>() / count
}

const MATTE: &str = "material_principled m { base_color { .5 .5 .5 } ior 1 specular_ior_level 0 } ";

/// A floor, x and y from -2 to 2, whose texture coordinates grow with x and y.
const FLOOR: &str = "rectangle floor { material m lightMap 32 vertex0 { -2 -2 0 } vertex1 { 2 -2 0 } vertex2 { 2 2 0 } } ";

/// Floor and ceiling, and four walls about them; `more` holds further attributes of each.
fn room(more: &str) -> String {
    let sides = [
        ("floor", [[-2., -2., 0.], [2., -2., 0.], [2., 2., 0.]]),
        ("ceiling", [[-2., 2., 3.], [2., 2., 3.], [2., -2., 3.]]),
        ("left", [[-2., -2., 0.], [-2., 2., 0.], [-2., 2., 3.]]),
        ("right", [[2., 2., 0.], [2., -2., 0.], [2., -2., 3.]]),
        ("front", [[2., -2., 0.], [-2., -2., 0.], [-2., -2., 3.]]),
        ("back", [[-2., 2., 0.], [2., 2., 0.], [2., 2., 3.]]),
    ];
    sides.map(|(name, corners)| rectangle(name, "m", corners, more)).concat()
}

const INTEGRATORS: [&str; 5] = [
    "integrator DISTRIBUTED",
    "integrator PATH",
    "integrator PHOTON_MAP photonMapSize 20000",
    "integrator PHOTON_MAP photonMapSize 20000 cacheError .2 gatherRays 128",
    "integrator PHOTON_MAP photonMapSize 20000 gather 0",
];

#[test]
fn a_floor_under_a_point_lamp_has_the_irradiance_of_lamberts_law() {
    let lamp = "lamp_point l { power { 100 9 9 } position { .5 -.25 1 } }";
    for integrator in INTEGRATORS {
        let image = bake(&scene(integrator, 4, &[MATTE, FLOOR, lamp].concat()), "floor");
        for (x, y) in [(0, 0), (20, 17), (31, 0), (3, 31), (16, 16)] {
            // A texel is the mean of its points.
            let expected = |k: i32| {
                let (i, j) = (f64::from(k % 16) + 0.5, f64::from(k / 16) + 0.5);
                let px = -2.0 + 4.0 * (f64::from(x) + i / 16.0) / 32.0;
                let py = 2.0 - 4.0 * (f64::from(y) + j / 16.0) / 32.0;
                let square = (px - 0.5) * (px - 0.5) + (py + 0.25) * (py + 0.25) + 1.0;
                100.0 / (4.0 * PI * square * square.sqrt())
            };
            let expected = (0..256).map(expected).sum::<f64>() / 256.0;
            let (x, y) = (x as usize, y as usize);
            let found = mean(&image, x..x + 1, y..y + 1);
            assert!(
                (found / expected - 1.0).abs() < 0.02,
                "{integrator} {x} {y}: {found} {expected}"
            );
        }
    }
}

#[test]
fn closed_rooms_have_a_geometric_series_of_irradiance() {
    // Walls of albedo 1/2 that emit 1: E = pi L / (1 - rho).
    let walls = "material_principled m { base_color { .5 .5 .5 } ior 1 specular_ior_level 0 emission_strength 1 } ";
    for integrator in &INTEGRATORS[1..4] {
        let image =
            bake(&scene(integrator, 64, &(walls.to_owned() + &room("lightMap 8"))), "floor");
        // Beside a wall that glows, rays to it are noisy.
        let found = mean(&image, 2..6, 2..6);
        assert!((found / (2.0 * PI) - 1.0).abs() < 0.02, "{integrator}: {found}");
    }
    let ball = "sphere ball { material m center { 1 2 3 } radius 2 lightMap 16 lightMapInside 1 } ";
    // A lamp in the middle of a ball of albedo 1/2: E = P / (4 pi r²) / (1 - rho).
    let lamp = "lamp_point l { power { 100 9 9 } position { 1 2 3 } }";
    for integrator in &INTEGRATORS[1..] {
        let image = bake(&scene(integrator, 64, &[MATTE, ball, lamp].concat()), "ball");
        let (found, expected) = (mean(&image, 0..16, 0..16), 100.0 / (16.0 * PI) * 2.0);
        assert!((found / expected - 1.0).abs() < 0.02, "{integrator}: {found} {expected}");
    }
}

#[test]
fn a_light_map_is_that_of_one_side() {
    let sun = "lamp_sun l { irradiance { 2 2 2 } direction { 0 .6 -.8 } angle_deg 0 }";
    let inside = FLOOR.replace("lightMap 32", "lightMap 32 lightMapInside 1");
    let upper = bake(&scene("integrator PATH", 1, &[MATTE, FLOOR, sun].concat()), "floor");
    let lower = bake(&scene("integrator PATH", 1, &[MATTE, &inside, sun].concat()), "floor");
    assert!(upper.rgb.iter().all(|rgb| (rgb[0] - 1.6).abs() < 1e-4), "{:?}", upper.rgb[0]);
    assert!(lower.rgb.iter().all(|rgb| rgb[0] == 0.0), "{:?}", lower.rgb[0]);
}

#[test]
fn margins_show_what_lies_beside_them() {
    // Half of the image: no texel there, nor beside it, is darker.
    let triangle = "triangle floor { material m lightMap 32 vertex0 { -2 -2 0 } vertex1 { 2 -2 0 } vertex2 { 2 2 0 } } ";
    let sky = "environment e { radiance { 1 1 1 } }";
    let image = bake(&scene("integrator PATH", 16, &[MATTE, triangle, sky].concat()), "floor");
    let far = |rgb: &[f32; 3]| (f64::from(rgb[0]) / PI - 1.0).abs();
    let farthest = image.rgb.iter().map(far).fold(0.0, f64::max);
    assert!(farthest < 0.05, "{farthest}");
}

#[test]
fn objects_that_move_are_baked_where_they_are() {
    let lamp = "lamp_point l { power { 100 9 9 } position { 0 0 1 } }";
    let moved = FLOOR.replace(
        "lightMap 32",
        "lightMap 32 addKframe { time 0 key { pivot { -1 0 0 } } } addKframe { time .5 key { pivot { 1 0 0 } } }",
    );
    let image = bake(&scene("integrator PATH", 64, &[MATTE, &moved, lamp].concat()), "floor");
    let still = |x: f64| {
        let scene = scene(
            "integrator PATH",
            4,
            &[MATTE, FLOOR, &lamp.replace("{ 0 0 1 }", &format!("{{ {x} 0 1 }}"))].concat(),
        );
        bake(&scene, "floor")
    };
    let places = [-0.875, -0.625, -0.375, -0.125, 0.125, 0.375, 0.625, 0.875].map(still);
    for (x, y) in [(4, 4), (16, 16), (20, 12), (30, 1)] {
        let of = |image: &Image| mean(image, x..x + 1, y..y + 1);
        let (found, expected) = (of(&image), places.iter().map(of).sum::<f64>() / 8.0);
        assert!((found / expected - 1.0).abs() < 0.03, "{x} {y}: {found} {expected}");
    }
}

#[test]
fn all_threads_and_instruction_sets_make_the_same_bytes() {
    let room = "box b { material m vertex0 { -3 -3 -.5 } vertex1 { 3 -3 -.5 } vertex2 { 3 3 -.5 } height 3 } ";
    let lamp = "lamp_rectangle l { power { 50 40 30 } vertex0 { -.3 -.3 2 } vertex1 { -.3 .3 2 } vertex2 { .3 .3 2 } } ";
    for integrator in INTEGRATORS.into_iter().chain(["integrator PATH guide 1"]) {
        let scene = scene(integrator, 3, &[MATTE, FLOOR, room, lamp].concat());
        let expected = bake_on(1, &scene, "floor", Isa::best());
        assert!(expected.rgb.iter().any(|rgb| rgb[0] > 0.1));
        for threads in [2, 7] {
            assert!(bake_on(threads, &scene, "floor", Isa::best()) == expected, "{integrator}");
        }
        for isa in Isa::available() {
            assert!(bake_on(2, &scene, "floor", isa) == expected, "{integrator} {isa:?}");
        }
    }
}

#[test]
fn gathering_reads_light_maps_where_there_are_some() {
    let lamp =
        "lamp_disc l { power { 60 40 20 } center { 1 .5 2.5 } normal { 0 .5 -1 } radius .2 }";
    let settings = "integrator PHOTON_MAP photonMapSize 60000";
    let picture = |settings: &str, more: &str| {
        let (from, to) = (vec![[0.0, -1.5, 1.5]], vec![[0.0, 1.0, 1.0]]);
        let settings = settings.to_owned();
        let shot =
            Shot { from, to, fov: 0.9, samples: 16, recursion: 16, settings, ..Shot::default() };
        shot.take(&(MATTE.to_owned() + &room(more) + lamp))
    };
    let path = picture("integrator PATH", "");
    let expected = [0, 1, 2].map(|c| path.sum(c) / 4096.0);
    for more in ["", "cacheError .2 gatherRays 128"] {
        let settings = format!("{settings} {more}");
        let plain = picture(&settings, "");
        let read = picture(&settings, "lightMap 32");
        assert!(read.0 != plain.0, "{settings}: they are read");
        plain.assert_mean(expected, 0.025);
        read.assert_mean(expected, 0.025);
        // Maps of the other side are not.
        let other = picture(&settings, "lightMap 32 lightMapInside 1");
        assert!(other.0 == plain.0, "{settings}: the other side");
    }
}
