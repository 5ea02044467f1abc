//! Guiding changes the noise of a picture, and nothing else.

use glam::Vec3;
use rand::{RngExt, SeedableRng, rngs::StdRng};
use slo_accel::Isa;
use slo_picture::film::Film;
use slo_render::frame::FrameScene;
use slo_render::guiding::{Field, Learning, Record, direction, pack};
use slo_scene::SceneDescription;

use crate::support::{describe, expose_frame};

/// A room with a wall of its own for everything, lit by a lamp behind a screen and a bright spot
/// on the ceiling.
fn room(settings: &str, seed: u32) -> SceneDescription {
    describe(&format!(
        "settings s {{ integrator PATH imageSamples 8 recursion 3 seed {seed} {settings} }}
         Camera c {{
             fps 4
             Film f {{ width 32 height 24 prefix t output PNG_IMAGE }}
             CamSegment seg {{
                 videoStart 0 videoEnd 1 sceneStart 0 sceneEnd 1 fovStart .6
                 addPosition {{ 0 -1.9 1.1 }} addTarget {{ 0 2 .6 }}
             }}
         }}
         material_principled wall {{ base_color {{ .7 .6 .5 }} ior 1 specular_ior_level 0 }}
         material_principled brass {{ base_color {{ .9 .7 .4 }} metallic 1 roughness .6 }}
         material_principled lacquer {{ base_color {{ .2 .5 .3 }} roughness .55 coat .5 }}
         material_principled frost {{ base_color {{ 1 1 1 }} transmission 1 roughness .7 }}
         material_principled glass {{ base_color {{ 1 1 1 }} transmission 1 roughness 0 }}
         box walls {{ vertex0 {{ -2 -2 0 }} vertex1 {{ 2 -2 0 }} vertex2 {{ 2 2 0 }} height 2.5 material wall }}
         rectangle screen {{ vertex0 {{ .6 .2 0 }} vertex1 {{ .6 2 0 }} vertex2 {{ .6 2 2 }} material lacquer }}
         sphere ball {{ center {{ -.8 .8 .5 }} radius .5 material brass }}
         sphere egg {{ center {{ .1 .6 .3 }} radius .3 material frost }}
         sphere drop {{ center {{ -.2 -.2 .2 }} radius .2 material glass }}
         lamp_point lamp {{ power {{ 30 28 24 }} position {{ 1.3 1.2 .8 }} radius .1 }}
         lamp_spot spot {{ power {{ 40 50 60 }} position {{ 1.5 -1.5 .5 }} target {{ 0 1 2.5 }} angle_deg 30 }}"
    ))
}

fn built(description: &SceneDescription) -> FrameScene {
    FrameScene::build(description, 0, Isa::best()).expect("the frame can be built")
}

/// A field that knows nothing: at each place, light from a few directions that have nothing to do with
/// the scene.
fn wrong() -> Field {
    let mut rng = StdRng::seed_from_u64(3);
    let mut learning = Learning::default();
    for _ in 0..3 {
        let mut record = || {
            let place = Vec3::from_array(std::array::from_fn(|_| rng.random_range(-3.0..3.0)));
            let spot = (place.x * 2.0).floor() * 0.17 + (place.y * 2.0).floor() * 0.13 + 0.4;
            let [a, b] = [spot + 0.02 * rng.random::<f32>(), rng.random::<f32>() * 0.4];
            let toward = pack(direction([a.rem_euclid(1.0), b]));
            let value = rng.random_range(0.1..2.0);
            let (own, mixed) = (1.0, 1.0);
            Record { place, toward, value, own, field: 0.0, mixed, is_diffuse: rng.random() }
        };
        // And a little light from everywhere.
        let mut records: Vec<Record> = (0..40_000).map(|_| record()).collect();
        for record in records.iter_mut().step_by(10) {
            let at =
                [(record.place.x * 7.3).rem_euclid(1.0), (record.place.y * 9.1).rem_euclid(1.0)];
            record.toward = pack(direction(at));
        }
        learning.learn(&mut records);
    }
    learning.field()
}

/// Means of the left and the right half of pictures, and the variances of these means.
fn halves(pictures: &[Film]) -> [(f64, f64); 2] {
    [0, 1].map(|half| {
        let mean = |film: &Film| {
            let rgb = film.image().rgb;
            let mine = rgb.iter().enumerate().filter(|(i, _)| usize::from(i % 32 >= 16) == half);
            mine.map(|(_, p)| f64::from(p[0] + p[1] + p[2])).sum::<f64>() / rgb.len() as f64
        };
        let means: Vec<f64> = pictures.iter().map(mean).collect();
        let n = means.len() as f64;
        let mean = means.iter().sum::<f64>() / n;
        let variance = means.iter().map(|m| (m - mean) * (m - mean)).sum::<f64>() / (n - 1.0);
        (mean, variance / n)
    })
}

/// By how many standard deviations pictures differ.
fn apart(one: &[Film], other: &[Film]) -> f64 {
    let (one, other) = (halves(one), halves(other));
    let pairs = one.iter().zip(other);
    pairs.map(|((a, va), (b, vb))| (a - b).abs() / (va + vb).sqrt()).fold(0.0, f64::max)
}

const SEEDS: u32 = 32;

/// Limit that chance exceeds once in many thousand runs.
const APART: f64 = 4.5;

fn pictures(settings: &str, seeds: u32, with: impl Fn(FrameScene) -> FrameScene) -> Vec<Film> {
    let seeds = seeds..seeds + SEEDS;
    let picture = |seed| {
        let description = room(settings, seed);
        expose_frame(&description, &with(built(&description)))
    };
    seeds.map(picture).collect()
}

#[test]
fn a_wrong_field_gives_the_same_picture() {
    let field = wrong();
    assert!(field.sizes()[0] > 20 && field.guided()[1] > 0.3, "{:?}", field.guided());
    for settings in ["", "diffuseReflectionSamples 3", "photons 1"] {
        let plain = pictures(settings, 0, |frame| frame);
        let guided = pictures(settings, 1000, |frame| frame.with_field(field.clone()));
        let apart = apart(&plain, &guided);
        assert!(apart < APART, "{settings}: {apart}");
    }
}

#[test]
fn a_learned_field_gives_the_same_picture() {
    let plain = pictures("", 0, |frame| frame);
    let guided = pictures("guide 1", 1000, |frame| frame);
    let apart = apart(&plain, &guided);
    assert!(apart < APART, "{apart}");
}

#[test]
fn the_same_field_is_learned_by_all_threads_and_instruction_sets() {
    let description = room("guide 1", 5);
    let learned = |threads: usize, isa: Isa| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let frame = FrameScene::build(&description, 0, isa).unwrap();
            let film = expose_frame(&description, &frame);
            (frame.field().expect("it is learned").to_bytes(&[1; 32]), film.image())
        })
    };
    let (bytes, image) = learned(1, Isa::Portable);
    for threads in [1, 2, 7] {
        for isa in Isa::available() {
            let (other, picture) = learned(threads, isa);
            assert!(other == bytes, "{threads} {isa:?}");
            assert!(picture == image, "{threads} {isa:?}");
        }
    }
    // A machine that has the field renders the same picture.
    let field = Field::from_bytes(&bytes, &[1; 32]).unwrap();
    let frame = built(&description).with_field(field);
    assert!(expose_frame(&description, &frame).image() == image);
}
