//! What rays take in structures is counted exactly, and changes nothing.

use std::sync::atomic::{AtomicI64, Ordering};

use slo_accel::Isa;
use slo_accel::study::Totals;
use slo_picture::film::{Area, Film};
use slo_render::frame::FrameScene;
use slo_render::render::{Observer, Plan, Statistics, render};
use slo_scene::{Accelerator, Integrator, SceneDescription};

use crate::determinism::{everything, files};
use crate::support::{Shot, describe, expose, expose_counted, material};

const COUNTED: [Accelerator; 10] = [
    Accelerator::Bvh,
    Accelerator::KdTree,
    Accelerator::None,
    Accelerator::Grid,
    Accelerator::Octree,
    Accelerator::Median,
    Accelerator::RTree,
    Accelerator::Binary,
    Accelerator::Kd,
    Accelerator::Boxes,
];

/// Renders a scene and counts its rays, in total and by pixel.
fn count(scene: &SceneDescription, isa: Isa) -> (Film, Statistics, Vec<[u64; 2]>) {
    let mut frame = FrameScene::build(scene, 0, isa).unwrap();
    frame.count(true).unwrap();
    let (film, statistics) = expose_counted(scene, &frame);
    (film, statistics, frame.costs())
}

fn rays_and_hits(statistics: &Statistics) -> Vec<[u64; 2]> {
    statistics.rays.iter().map(|Totals { rays, hits, .. }| [*rays, *hits]).collect()
}

fn small(integrator: Integrator) -> SceneDescription {
    let mut scene = everything();
    (scene.camera.film.width, scene.camera.film.height) = (29, 23);
    scene.settings.integrator = integrator;
    scene
}

/// The strongest test that there is: all structures see the same rays hit the same things.
#[test]
fn numbers_of_rays_and_hits_do_not_depend_on_the_structure() {
    for integrator in [Integrator::Distributed, Integrator::Path] {
        let mut scene = small(integrator);
        let expected = files(&scene, &expose(&scene, Isa::best()));
        let mut known: Option<Vec<[u64; 2]>> = None;
        for accelerator in COUNTED {
            scene.settings.accelerator = accelerator;
            let (film, statistics, costs) = count(&scene, Isa::best());
            let what = format!("{integrator:?} {accelerator:?}");
            assert!(files(&scene, &film) == expected, "{what}: the picture");
            let found = rays_and_hits(&statistics);
            let known = known.get_or_insert_with(|| found.clone());
            assert_eq!(found, *known, "{what}");
            let [camera, shadow] = [found[0][0], found[1][0]];
            assert_eq!(camera, statistics.camera_rays, "{what}");
            assert_eq!(shadow, statistics.shadow_rays, "{what}");
            let rest: u64 = found[2..].iter().map(|[rays, _]| rays).sum();
            assert_eq!(rest, statistics.bounce_rays, "{what}");
            let sum = |of: fn(&Totals) -> u64| statistics.rays.iter().map(of).sum::<u64>();
            let sums = [sum(|totals| totals.sum.steps), sum(|totals| totals.sum.tests)];
            let of_pixels =
                costs.iter().fold([0; 2], |[a, b], [steps, tests]| [a + steps, b + tests]);
            assert_eq!(of_pixels, sums, "{what}");
            assert!(sums[1] > 0 && costs.len() == 29 * 23, "{what}");
        }
        let found = known.unwrap();
        assert!(found.iter().all(|[rays, hits]| hits <= rays));
        // Mirrors and glass; with paths, also matt surfaces.
        assert!(found[2][0] > 1000 && (found[4][0] > 100) == (integrator == Integrator::Path));
    }
}

#[test]
fn counts_are_the_same_for_all_threads_and_instruction_sets() {
    let mut scene = small(Integrator::Path);
    for accelerator in [Accelerator::Bvh, Accelerator::KdTree, Accelerator::Grid] {
        scene.settings.accelerator = accelerator;
        let (_, expected, costs) = count(&scene, Isa::Portable);
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            for isa in Isa::available() {
                let (_, found, of_pixels) = pool.install(|| count(&scene, isa));
                assert_eq!(found, expected, "{accelerator:?} {threads} {isa}");
                assert!(of_pixels == costs, "{accelerator:?} {threads} {isa}");
            }
        }
    }
}

#[test]
fn what_cannot_be_counted_is_said() {
    let mut scene = small(Integrator::Distributed);
    let refused = |scene: &SceneDescription| {
        FrameScene::build(scene, 0, Isa::best()).unwrap().count(false).unwrap_err().to_string()
    };
    scene.settings.accelerator = Accelerator::Cwbvh;
    assert_eq!(refused(&scene), "CWBVH does not count");
    let copies = "sphere s { center { 0 0 0 } radius 1 material matt }
        copy a { of s addKframe { time 0 key { pivot { 2 0 0 } } } }";
    let elements = material("matt", "diffuse { .5 .4 .3 }") + copies;
    let scene = describe(&Shot::default().of(&elements));
    let mut frame = FrameScene::build(&scene, 0, Isa::best()).unwrap();
    // Few copies are kept one by one.
    assert!(frame.count(false).is_ok() && frame.costs().is_empty());
    assert!(frame.counted_structures().iter().all(|of| of.memory > 0));
}

/// Is asked so many times whether to go on.
struct Impatient(AtomicI64);

impl Observer for Impatient {
    fn advanced(&self, _share: f64) {}

    fn gives_up(&self) -> bool {
        self.0.fetch_sub(1, Ordering::SeqCst) <= 1
    }
}

/// Without a hierarchy, a batch of rays takes long, so who gives up does not wait for all of them.
#[test]
fn counting_stops_between_two_rays() {
    let mut scene = small(Integrator::Distributed);
    scene.settings.accelerator = Accelerator::None;
    scene.settings.set_camera_samples(1);
    let mut frame = FrameScene::build(&scene, 0, Isa::best()).unwrap();
    frame.count(true).unwrap();
    let plan = Plan::new(&scene);
    let film = Film::new(Area::whole(29, 23), plan.needs_spreads()).unwrap();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let observer = Impatient(AtomicI64::new(20));
    let exposed = pool.install(|| render(&frame, &plan, film, &observer));
    assert!(!exposed.is_complete);
    let counted = frame.costs().iter().filter(|costs| **costs != [0; 2]).count();
    assert!((1..20).contains(&counted), "{counted} pixels");
}
