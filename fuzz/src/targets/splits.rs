//! However a picture's samples are divided, stopped and merged, the film is the same.

use std::sync::LazyLock;
use std::sync::atomic::{AtomicI64, Ordering};

use slo_accel::Isa;
use crate::pieces::Numbers;
use slo_picture::film::{Area, Film, FirstHitLayers, Merger, State, Subject};
use slo_picture::output::{Recipe, read_state, write_state};
use slo_render::frame::FrameScene;
use slo_render::render::{Observer, Part, Plan, render};
use slo_scene::{Files, Layer, SceneDescription, load};

/// A scene, its frame, and its film after one run.
struct Whole {
    scene: SceneDescription,
    frame: FrameScene,
    film: Film,
}

const SETTINGS: [&str; 5] = [
    "imageSamples 7",
    "imageSamples 8 integrator PATH",
    "imageSamples 5 imageMinSamples 2 imageContrastLimit 0.1",
    "imageSamples 12 imageMinSamples 4 noise 0.03",
    "imageSamples 6 integrator PATH photons 20",
];

static WHOLES: LazyLock<Vec<Whole>> = LazyLock::new(|| {
    let whole = |(i, settings): (usize, &&str)| {
        let text = include_str!("../../seeds/splits.txt").replace("SETTINGS", settings);
        let loaded = load("splits.txt", &text, &Files::in_memory("", []));
        let said = loaded.diagnostics.render(false);
        let mut scene = loaded.scene.unwrap_or_else(|| panic!("{said}"));
        if i % 2 == 1 {
            scene.camera.film.layers = Layer::ALL.to_vec();
        }
        let frame = FrameScene::build(&scene, 0, Isa::best()).expect("a frame");
        let plan = Plan::new(&scene);
        let subject = subject(&scene, &plan, area(&scene));
        let film = subject.film().expect("a film");
        let film = render(&frame, &plan, film, &Patient).film;
        Whole { scene, frame, film }
    };
    SETTINGS.iter().enumerate().map(whole).collect()
});

struct Patient;

impl Observer for Patient {
    fn advanced(&self, _share: f64) {}

    fn should_stop(&self) -> bool {
        false
    }
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

pub(crate) fn run(data: &[u8]) {
    crate::prepare();
    LazyLock::force(&WHOLES);
    let mut numbers = Numbers::of(data);
    let whole = &WHOLES[numbers.below(WHOLES.len())];
    let scene = &whole.scene;
    let mut shares = Vec::new();
    for region in regions(area(scene), &mut numbers) {
        let of = 1 + numbers.below(3) as u32;
        let by_samples = numbers.byte().is_multiple_of(2);
        for number in 1..=of {
            let (plan, part) = (Plan::new(scene), Part { number, of });
            let samples = plan.clone().of_samples(part).filter(|_| by_samples);
            let plan = samples.unwrap_or_else(|| plan.of_part(part));
            if plan.samples().is_none_or(|range| !range.is_empty()) {
                let place = numbers.below(shares.len() + 1);
                shares.insert(place, (region, plan));
            }
        }
    }
    let complete =
        Subject { recipe: String::new(), ..subject(scene, &Plan::new(scene), area(scene)) };
    let mut merger = Merger::new(&complete, scene.settings.image_samples).expect("a merger");
    for (number, (region, plan)) in shares.iter().enumerate() {
        merger.add(number, &state(whole, *region, plan, &mut numbers)).expect("they fit");
    }
    let film = merger.finish().expect("all are there");
    assert!(film == whole.film, "other sums: {shares:?}");
}

fn area(scene: &SceneDescription) -> Area {
    Area::whole(scene.camera.film.width, scene.camera.film.height)
}

fn subject(scene: &SceneDescription, plan: &Plan, region: Area) -> Subject {
    let has_layers = !scene.camera.film.layers.is_empty();
    Subject {
        recipe: Recipe { scene, frame: 0 }.to_json(),
        area: region.in_blocks(&area(scene)),
        region,
        samples: plan.samples(),
        with_spreads: plan.needs_spreads(),
        with_features: has_layers,
        light_groups: has_layers.then(|| scene.light_groups()),
        first_hits: FirstHitLayers::of(&scene.camera.film.layers, &scene.layer_names()),
    }
}

/// Cuts an area into up to four regions.
fn regions(area: Area, numbers: &mut Numbers<'_>) -> Vec<Area> {
    let mut regions = vec![area];
    for _ in 0..numbers.below(4) {
        let area = regions.swap_remove(numbers.below(regions.len()));
        if numbers.byte().is_multiple_of(2) && area.width() > 1 {
            let x = area.x0 + 1 + numbers.below(area.width() as usize - 1) as u32;
            regions.extend([Area { x1: x, ..area }, Area { x0: x, ..area }]);
        } else if area.height() > 1 {
            let y = area.y0 + 1 + numbers.below(area.height() as usize - 1) as u32;
            regions.extend([Area { y1: y, ..area }, Area { y0: y, ..area }]);
        } else {
            regions.push(area);
        }
    }
    regions
}

/// Renders a share, stopped several times and continued from a file.
fn state(whole: &Whole, region: Area, plan: &Plan, numbers: &mut Numbers<'_>) -> State {
    let subject = subject(&whole.scene, plan, region);
    let mut film = subject.film().expect("a film");
    let path = crate::folder().join("state");
    loop {
        let observer = Impatient {
            steps: AtomicI64::new(1 + numbers.below(10) as i64),
            batches: AtomicI64::new(20 + numbers.below(200) as i64),
        };
        let observer: &dyn Observer = if numbers.is_empty() { &Patient } else { &observer };
        let exposed = render(&whole.frame, plan, film, observer);
        let is_complete = exposed.is_complete;
        let state = State { subject: subject.clone(), film: exposed.film, is_complete };
        write_state(&path, &state).expect("it is written");
        let state = read_state(&path).expect("it is read");
        if is_complete {
            return state;
        }
        film = state.film;
    }
}
