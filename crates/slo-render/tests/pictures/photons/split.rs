//! Whoever traces the photons, in however many runs: the sums are the same.

use std::sync::atomic::{AtomicI64, Ordering};
use std::time::{Duration, Instant};

use slo_accel::Isa;
use slo_picture::film::{Area, Film, Fixed, LEAST_FOR_NOISE, Steps};
use slo_render::frame::FrameScene;
use slo_render::integrator::{PhotonPass, PhotonTracer};
use slo_render::photons::Photon;
use slo_render::render::{Budget, Observer, Part, Plan, render, render_until};
use slo_scene::SceneDescription;

use crate::support::describe;

/// Caustics of a moving ball of glass and of a mirror, with a lens.
fn scene(settings: &str) -> SceneDescription {
    describe(&format!(
        "settings s {{ integrator PATH recursion 5 photons .4 {settings} }}
         Camera c {{
             fps 25
             Film f {{ width 70 height 41 prefix test output PNG16_IMAGE }}
             CamSegment only {{
                 videoStart 0 videoEnd 1 sceneStart 0 sceneEnd 1 blurDuration .04
                 addPosition {{ 0 -5 1.5 }} addTarget {{ 0 0 0 }} fovStart .4 dofStart 5 lensRadiusStart .1
             }}
         }}
         lamp_point key {{ power {{ 200 180 150 }} position {{ 2 -1 4 }} }}
         lamp_sun sun {{ irradiance {{ 1 1 2 }} direction {{ 1 1 -2 }} angle_deg 2 }}
         material_principled matte {{ base_color {{ .6 .6 .6 }} }}
         material_principled glass {{ transmission 1 roughness 0 }}
         material_principled veil {{ metallic 1 roughness .2 alpha .7 }}
         plane floor {{ normal {{ 0 0 1 }} position {{ 0 0 -1 }} material matte }}
         box block {{ vertex0 {{ -2 .5 -1 }} vertex1 {{ -1 .5 -1 }} vertex2 {{ -1 1.5 -1 }} height 1.5 material veil }}
         sphere ball {{ center {{ 0 0 0 }} radius .8 material glass
             addKframe {{ time 0 key {{ pivot {{ 0 0 0 }} }} }}
             addKframe {{ time 1 key {{ pivot {{ 3 0 0 }} }} }} }}"
    ))
}

/// The picture's film without samples.
fn empty(scene: &SceneDescription) -> Film {
    let area = Area::whole(scene.camera.film.width, scene.camera.film.height);
    Film::new(area, Plan::new(scene).needs_spreads()).unwrap()
}

struct Patient;

impl Observer for Patient {
    fn advanced(&self, _share: f64) {}
}

/// Stops after a number of steps, or gives up after a number of questions.
struct Impatient {
    steps: AtomicI64,
    questions: AtomicI64,
}

impl Observer for Impatient {
    fn advanced(&self, _share: f64) {}

    fn should_stop(&self) -> bool {
        self.steps.fetch_sub(1, Ordering::Relaxed) <= 0
    }

    fn gives_up(&self) -> bool {
        self.questions.fetch_sub(1, Ordering::Relaxed) <= 0
    }
}

fn on_threads<T: Send>(threads: usize, run: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(run)
}

fn whole(scene: &SceneDescription, plan: &Plan, threads: usize) -> Film {
    let frame = FrameScene::build(scene, 0, Isa::best()).unwrap();
    let exposed = on_threads(threads, || render(&frame, plan, empty(scene), &Patient));
    assert!(exposed.is_complete);
    exposed.film
}

/// Renders in runs that are stopped again and again. Returns the film and the number of runs.
fn stopped(scene: &SceneDescription, plan: &Plan, threads: usize) -> (Film, usize) {
    let frame = FrameScene::build(scene, 0, Isa::best()).unwrap();
    let (mut film, mut runs) = (empty(scene), 0);
    loop {
        runs += 1;
        let observer = Impatient {
            steps: AtomicI64::new(60 * (1 + runs % 9)),
            questions: AtomicI64::new(200 * (1 + runs % 13)),
        };
        let exposed = on_threads(threads, || render(&frame, plan, film, &observer));
        film = exposed.film;
        if exposed.is_complete {
            return (film, runs as usize);
        }
        assert!(runs < 2000, "it makes no progress");
    }
}

#[test]
fn stops_at_any_sample_do_not_show() {
    for settings in [
        "imageSamples 19",
        "imageSamples 40 imageMinSamples 4 noise .05",
        "imageSamples 9 imageMinSamples 3 imageContrastLimit .2",
    ] {
        let scene = scene(settings);
        let plan = Plan::new(&scene);
        let expected = whole(&scene, &plan, 2);
        for threads in [1, 7] {
            assert!(whole(&scene, &plan, threads) == expected, "{settings}, {threads} threads");
            let (found, runs) = stopped(&scene, &plan, threads);
            assert!(runs > 1, "{runs} runs");
            assert!(found == expected, "{settings}, {threads} threads, {runs} runs");
        }
    }
}

#[test]
fn more_samples_later_are_the_same_samples() {
    let (few, many) = (scene("imageSamples 11"), scene("imageSamples 27"));
    let frame = FrameScene::build(&many, 0, Isa::best()).unwrap();
    let film = whole(&few, &Plan::new(&few), 2);
    let film = render(&frame, &Plan::new(&many), film, &Patient).film;
    assert!(film == whole(&many, &Plan::new(&many), 2));
}

/// The sums of several films, whose samples are different ones of the same pixels.
fn sum(films: &[Film]) -> Vec<[Fixed; 3]> {
    let mut sums: Vec<_> = films[0].pixels().iter().map(|pixel| pixel.sum).collect();
    for film in &films[1..] {
        for (sum, pixel) in sums.iter_mut().zip(film.pixels()) {
            (0..3).for_each(|c| sum[c] += pixel.sum[c]);
        }
    }
    sums
}

#[test]
fn passes_of_64_samples_are_the_sum_of_those_of_parts() {
    let scene = scene("imageSamples 64");
    let plan = Plan::new(&scene);
    let part = |number, of| plan.clone().of_samples(Part { number, of }).unwrap();
    let all = whole(&scene, &plan, 2);
    let quarters: Vec<_> = (1..=4).map(|k| whole(&scene, &part(k, 4), 1)).collect();
    assert!(sum(&quarters) == sum(std::slice::from_ref(&all)), "0-15, 16-31, 32-47, 48-63");
    // Borders within passes: 9, 18, 27, 36, 45, 54.
    let sevenths: Vec<_> = (1..=7).map(|k| stopped(&scene, &part(k, 7), 2).0).collect();
    assert!(sum(&sevenths) == sum(std::slice::from_ref(&all)), "sevenths");
}

#[test]
fn steps_of_time_can_be_resumed_and_repeated() {
    let scene = scene("imageSamples 64");
    let frame = FrameScene::build(&scene, 0, Isa::best()).unwrap();
    let plan = Plan::new(&scene).in_steps(Steps { done: Steps::LAST, tiles: 0 });
    // Time is up at once: what was reached is still completed.
    let until = |film: Film, least: Steps, observer: &dyn Observer| {
        let budget = Budget { least, deadline: Instant::now(), last: Steps::LAST };
        render_until(&frame, &plan, film, observer, budget)
    };
    let (exposed, reached) = until(empty(&scene), Steps { done: 5, tiles: 0 }, &Patient);
    assert!(exposed.is_complete && reached == Steps { done: 5, tiles: 0 }, "{reached:?}");
    let expected = exposed.film;
    assert!(expected.sample_counts().iter().any(|count| *count >= LEAST_FOR_NOISE));
    // Without the clock.
    let repeated = whole(&scene, &Plan::new(&scene).in_steps(reached), 2);
    assert!(repeated == expected, "repeated");
    // Stopped, and resumed with what was reached.
    let (mut film, mut runs) = (empty(&scene), 0);
    loop {
        runs += 1;
        let observer = Impatient {
            steps: AtomicI64::new(60 * (1 + runs % 9)),
            questions: AtomicI64::new(200 * (1 + runs % 13)),
        };
        let (exposed, _) = until(film, Steps { done: 5, tiles: 0 }, &observer);
        film = exposed.film;
        if exposed.is_complete {
            break;
        }
        assert!(runs < 2000, "it makes no progress");
    }
    assert!(film == expected, "resumed after {runs} stops");
    // A later deadline adds steps of all tiles.
    let deadline = Instant::now() + Duration::from_millis(500);
    let budget = Budget { least: reached, deadline, last: 8 };
    let (exposed, later) = render_until(&frame, &plan, expected, &Patient, budget);
    assert_eq!(later.tiles, 0, "photons serve all tiles");
    assert!(exposed.film == whole(&scene, &Plan::new(&scene).in_steps(later), 2), "{later:?}");
}

#[test]
fn regions_and_tiles_are_cut_out_of_the_whole() {
    let scene = scene("imageSamples 10");
    let frame = FrameScene::build(&scene, 0, Isa::best()).unwrap();
    let plan = Plan::new(&scene);
    let expected = whole(&scene, &plan, 2);
    let area = Area { x0: 8, y0: 16, x1: 56, y1: 40 };
    let region = render(&frame, &plan, Film::new(area, false).unwrap(), &Patient).film;
    assert!(region.image() == expected.image_of(area));
    let mut film = empty(&scene);
    for number in 1..=3 {
        film = render(&frame, &plan.clone().of_part(Part { number, of: 3 }), film, &Patient).film;
    }
    assert!(film == expected);
}

/// The photons of a pass of a frame of the scene at rest.
fn photons(settings: &str, number: i64) -> Vec<(f32, Photon)> {
    let mut scene = scene(settings);
    scene.objects.iter_mut().for_each(|object| object.key_frames.clear());
    let frame = FrameScene::build(&scene, number, Isa::best()).unwrap();
    let pass = PhotonPass::new(&frame, 3);
    PhotonTracer::default().trace(&frame, pass, 0..pass.paths(), &|| false).unwrap()
}

#[test]
fn a_fixed_seed_keeps_photons_where_they_are() {
    let moves = |settings| {
        let (first, second) = (photons(settings, 0), photons(settings, 1));
        assert!(first.len() > 100, "{settings}");
        first != second
    };
    assert!(moves("imageSamples 4"));
    assert!(!moves("imageSamples 4 photonSeed FIXED"));
    assert!(photons("photonSeed FIXED seed 1", 0) != photons("photonSeed FIXED", 0));
}

#[test]
fn pieces_of_a_pass_are_the_pass() {
    let scene = scene("imageSamples 4");
    let frame = FrameScene::build(&scene, 0, Isa::best()).unwrap();
    let pass = PhotonPass::new(&frame, 2);
    let trace = |tracer: &mut PhotonTracer, range| tracer.trace(&frame, pass, range, &|| false);
    let key = |(time, p): &(f32, Photon)| {
        (p.position.to_array().map(f32::to_bits), time.to_bits(), p.light, p.bounces, p.toward)
    };
    let sorted = |mut photons: Vec<(f32, Photon)>| {
        photons.sort_by_key(key);
        photons
    };
    let whole = sorted(trace(&mut PhotonTracer::default(), 0..pass.paths()).unwrap());
    let mut pieces = Vec::new();
    let mut tracer = PhotonTracer::default();
    for start in (0..pass.paths()).step_by(300).collect::<Vec<_>>().into_iter().rev() {
        let range = start..(start + 300).min(pass.paths());
        pieces.extend(trace(&mut tracer, range).unwrap());
    }
    assert!(whole.len() > 100 && sorted(pieces) == whole);
}
