//! However a picture's work is divided, stopped and continued, its file is the same.

use std::path::Path;
use std::sync::atomic::{AtomicI64, Ordering};

use rand::rngs::StdRng;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use slo_accel::Isa;
use slo_picture::film::{Area, FileLayer, Film, FirstHitLayers, Merger, State, Subject};
use slo_picture::output::{Picture, Recipe, read_state, write_state};
use slo_render::frame::FrameScene;
use slo_render::render::{Observer, Part, Plan, render};
use slo_scene::{Layer, OutputFormat, SceneDescription};

use crate::support::{describe, expose};

const CASES: usize = 100;

/// Motion blur, lens and soft shadow in a picture whose sides are multiples of neither tiles nor
/// blocks.
fn scene(settings: &str) -> SceneDescription {
    describe(&format!(
        "settings s {{ recursion 1 {settings} }}
         Camera c {{
             fps 25
             Film f {{ width 77 height 45 prefix test output PNG16_IMAGE encoding SRGB }}
             CamSegment only {{
                 videoStart 0 videoEnd 1 sceneStart 0 sceneEnd 1 blurDuration 0.04
                 addPosition {{ 0 -5 1 }} addTarget {{ 0 0 0 }} skyStart {{ 0 0 1 }}
                 fovStart 0.4 dofStart 5 lensRadiusStart 0.2
             }}
         }}
         light_rectangle lamp {{ color {{ 1 1 1 }}
             vertex0 {{ 2 -3 4 }} vertex1 {{ 3 -3 4 }} vertex2 {{ 3 -2 4 }} }}
         phong_info matte {{ ambient {{ .1 .1 .1 }} diffuse {{ .7 .6 .5 }} reflectance .2 }}
         material_phong matte {{ phong_info matte }}
         plane floor {{ normal {{ 0 0 1 }} position {{ 0 0 -1 }} material matte }}
         sphere ball {{ center {{ 0 0 0 }} radius 1 material matte
             addKframe {{ time 0 key {{ pivot {{ 0 0 0 }} }} }}
             addKframe {{ time 1 key {{ pivot {{ 3 0 0 }} }} }} }}"
    ))
}

fn whole(scene: &SceneDescription) -> Area {
    Area::whole(scene.camera.film.width, scene.camera.film.height)
}

/// Whether the film has all layers; otherwise it has none.
fn has_layers(scene: &SceneDescription) -> bool {
    !scene.camera.film.layers.is_empty()
}

fn first_hits(scene: &SceneDescription) -> FirstHitLayers {
    FirstHitLayers::of(&scene.camera.film.layers, &scene.layer_names())
}

fn file(scene: &SceneDescription, film: &Film) -> Vec<u8> {
    let (image, recipe) = (film.image(), Recipe { scene, frame: 0 }.to_json());
    let settings = &scene.camera.film;
    let (format, look) = (settings.output, settings.look(&scene.settings));
    let picture = Picture { image: &image, format, look, recipe: &recipe, crop: None };
    let layers = FileLayer::all(&settings.layers, &scene.layer_names());
    let layers = film.layers_of(film.area(), layers);
    let mut out = std::io::Cursor::new(Vec::new());
    picture.write_with(&mut out, &layers).unwrap();
    out.into_inner()
}

/// Stops a rendering after some steps, or in the middle of one.
struct Impatient {
    steps: AtomicI64,
    batches: AtomicI64,
}

impl Observer for Impatient {
    fn advanced(&self, _share: f64) {}

    fn should_stop(&self) -> bool {
        self.steps.fetch_sub(1, Ordering::Relaxed) <= 0
    }

    fn gives_up(&self) -> bool {
        self.batches.fetch_sub(1, Ordering::Relaxed) <= 0
    }
}

/// A share of the work.
#[derive(Clone, Debug)]
struct Share {
    region: Area,
    plan: Plan,
}

/// Cuts an area into up to `cuts + 1` regions.
fn regions(area: Area, cuts: usize, random: &mut StdRng) -> Vec<Area> {
    let mut regions = vec![area];
    for _ in 0..cuts {
        let area = regions.swap_remove(random.random_range(0..regions.len()));
        if random.random() && area.width() > 1 {
            let x = random.random_range(area.x0 + 1..area.x1);
            regions.extend([Area { x1: x, ..area }, Area { x0: x, ..area }]);
        } else if area.height() > 1 {
            let y = random.random_range(area.y0 + 1..area.y1);
            regions.extend([Area { y1: y, ..area }, Area { y0: y, ..area }]);
        } else {
            regions.push(area);
        }
    }
    regions
}

/// The work of a region in parts, by pixels or by samples.
fn parts(plan: &Plan, of: u32, random: &mut StdRng) -> Vec<Plan> {
    let by_samples = random.random();
    let part = |number| {
        let part = Part { number, of };
        let samples = plan.clone().of_samples(part).filter(|_| by_samples);
        samples.unwrap_or_else(|| plan.clone().of_part(part))
    };
    let empty = |plan: &Plan| plan.samples().is_some_and(|range| range.is_empty());
    (1..=of).map(part).filter(|plan| !empty(plan)).collect()
}

/// Renders a share, stopped several times and continued from a file, on 1 to 3 threads.
fn state(scene: &SceneDescription, share: &Share, folder: &Path, random: &mut StdRng) -> State {
    let Share { region, plan } = share;
    let subject = Subject {
        recipe: Recipe { scene, frame: 0 }.to_json(),
        area: region.in_blocks(&whole(scene)),
        region: *region,
        samples: plan.samples(),
        with_spreads: plan.needs_spreads(),
        with_features: has_layers(scene),
        light_groups: has_layers(scene).then(|| scene.light_groups()),
        first_hits: first_hits(scene),
    };
    let frame = FrameScene::build(scene, 0, Isa::best()).unwrap();
    let threads = rayon::ThreadPoolBuilder::new().num_threads(random.random_range(1..4));
    let threads = threads.build().unwrap();
    let mut film = subject.film().unwrap();
    loop {
        let observer = Impatient {
            steps: AtomicI64::new(random.random_range(1..12)),
            batches: AtomicI64::new(random.random_range(20..400)),
        };
        let exposed = threads.install(|| render(&frame, plan, film, &observer));
        let is_complete = exposed.is_complete;
        let state = State { subject: subject.clone(), film: exposed.film, is_complete };
        write_state(&folder.join("state"), &state).unwrap();
        let state = read_state(&folder.join("state")).unwrap();
        if is_complete {
            return state;
        }
        film = state.film;
    }
}

#[test]
fn any_split_any_order_any_stops_give_the_same_file() {
    let mut random = StdRng::seed_from_u64(2011);
    let folder = tempfile::tempdir().unwrap();
    let mut scenes = [
        "imageSamples 7",
        "imageSamples 8",
        "imageSamples 5 imageMinSamples 2 imageContrastLimit 0.1",
        "imageSamples 24 imageMinSamples 4 noise 0.03",
    ]
    .map(scene);
    for scene in &mut scenes[1..3] {
        scene.camera.film.output = OutputFormat::Exr;
        scene.camera.film.layers = Layer::ALL.to_vec();
    }
    let expected = scenes.each_ref().map(|scene| {
        let film = expose(scene, Isa::best());
        (file(scene, &film), film)
    });
    let counts = expected[3].1.sample_counts();
    assert!(counts.contains(&4) && counts.iter().any(|&n| n > 8), "{counts:?}");
    for case in 0..CASES {
        let i = random.random_range(0..scenes.len());
        let scene = &scenes[i];
        let cuts = random.random_range(0..4);
        let mut shares = Vec::new();
        for region in regions(whole(scene), cuts, &mut random) {
            let of = random.random_range(1..4);
            let plans = parts(&Plan::new(scene), of, &mut random);
            shares.extend(plans.into_iter().map(|plan| Share { region, plan }));
        }
        shares.shuffle(&mut random);
        let subject = Subject {
            recipe: String::new(),
            area: whole(scene),
            region: whole(scene),
            samples: None,
            with_spreads: Plan::new(scene).needs_spreads(),
            with_features: has_layers(scene),
            light_groups: has_layers(scene).then(|| scene.light_groups()),
            first_hits: first_hits(scene),
        };
        let all = scene.settings.image_samples;
        let mut merger = Merger::new(&subject, all).unwrap();
        for (number, share) in shares.iter().enumerate() {
            let state = state(scene, share, folder.path(), &mut random);
            merger.add(number, &state).unwrap_or_else(|e| panic!("case {case}: {e:?} {shares:?}"));
        }
        let film = merger.finish().unwrap_or_else(|e| panic!("case {case}: {e:?} {shares:?}"));
        assert!(film == expected[i].1, "case {case}: other sums; {shares:?}");
        assert!(file(scene, &film) == expected[i].0, "case {case}: other bytes; {shares:?}");
    }
}
