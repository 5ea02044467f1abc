//! Published counts, and what holds for every structure to study. Hits are compared with brute force
//! by the tests of all structures.

mod published;
mod scenes;

use super::*;
use crate::structure::testing::Random;
use crate::structure::{Accelerator, BuildOptions, Structure};
use crate::{Coherence, Hits, Isa, Primitives, Scratch};

/// Settings that change how each structure is built or traversed.
fn ways() -> Vec<Parameters> {
    let usual = Parameters::default();
    vec![
        Parameters { mailbox: true, ..usual },
        Parameters { density: Some(0.3), depth: Some(3), ..usual },
        Parameters { density: Some(20.0), leaf: Some(5), mailbox: true, ..usual },
        Parameters { shortest: Some(4.0), depth: Some(0), ..usual },
        Parameters { planes: Planes::Cost, ..usual },
        Parameters { planes: Planes::Cost, depth: Some(24), leaf: Some(3), ..usual },
        Parameters { cells: Some([1, 70, 3]), depth: Some(8), capacity: Some(2), ..usual },
        Parameters { traversal: Traversal::Restart, capacity: Some(100), ..usual },
        Parameters { traversal: Traversal::PushDown, mailbox: true, ..usual },
        Parameters { traversal: Traversal::ShortStack, leaf: Some(2), ..usual },
        Parameters { traversal: Traversal::ShortStack, stack: Some(1), ..usual },
    ]
}

#[test]
fn parameters_change_no_hit() {
    let mut random = Random::new(11);
    let (mut triangles, curved) = (random.triangles(300, 0.3), random.curved(20, 0.2));
    triangles.extend_from_within(..20);
    let mut primitives = Primitives { triangles, curved };
    let rays = random.rays(3000, 1.0);
    let mut scratch = Scratch::default();
    for round in 0..2 {
        if round == 1 {
            // A flat scene, along whose planes some rays run.
            primitives.curved.clear();
            primitives.triangles.iter_mut().flatten().for_each(|p| p.z = 0.25);
        }
        let mut ask = |accelerator, parameters| {
            let options = BuildOptions::new(Isa::best()).with_parameters(parameters);
            let structure = Structure::build(accelerator, primitives.clone(), options);
            let (mut hits, mut blocked) = (Hits::default(), vec![]);
            structure.intersect(&rays, Coherence::Incoherent, &mut hits, &mut scratch);
            structure.occluded(&rays, Coherence::Incoherent, &mut blocked, &mut scratch);
            let bits = |of: &[f32]| of.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            (bits(&hits.t), bits(&hits.u), bits(&hits.v), hits.primitive, blocked)
        };
        let expected = ask(Accelerator::None, Parameters::default());
        assert!(expected.3.iter().filter(|&&id| id != crate::NO_HIT).count() > 500);
        for &(name, _) in Kind::NAMES {
            let accelerator = Accelerator::by_name(name).expect("the renderer knows it too");
            for parameters in ways() {
                assert!(ask(accelerator, parameters) == expected, "{name}, {parameters:?}");
            }
        }
    }
}

/// Scenes that are very large, very small, far away or of very different sizes.
#[test]
fn extreme_scenes_are_hit_as_brute_force_hits_them() {
    for (seed, (scale, offset)) in
        (20..).zip([(1e-20f32, 0.0f32), (1e-6, 1.0), (1e15, 0.0), (1e30, 0.0), (1.0, 1e5)])
    {
        let mut random = Random::new(seed);
        let mut primitives: Primitives = random.triangles(200, 0.5).into();
        let to = |p: glam::Vec3| p * scale + glam::Vec3::splat(offset);
        primitives.triangles.iter_mut().flatten().for_each(|p| *p = to(*p));
        let mut rays = random.rays(1000, 1.0);
        for i in 0..rays.len() {
            for axis in 0..3 {
                rays.origin[axis][i] = rays.origin[axis][i] * scale + offset;
                if i % 2 == 0 && scale > 1e-10 {
                    rays.direction[axis][i] *= scale;
                }
            }
        }
        let mut scratch = Scratch::default();
        let mut ask = |accelerator| {
            let structure = Structure::build(accelerator, primitives.clone(), Isa::best());
            let (mut hits, mut blocked) = (Hits::default(), vec![]);
            structure.intersect(&rays, Coherence::Incoherent, &mut hits, &mut scratch);
            structure.occluded(&rays, Coherence::Incoherent, &mut blocked, &mut scratch);
            (hits.t, hits.primitive, blocked)
        };
        let expected = ask(Accelerator::None);
        for &(name, _) in Kind::NAMES {
            let accelerator = Accelerator::by_name(name).expect("the renderer knows it too");
            assert!(ask(accelerator) == expected, "{name}, scale {scale}, offset {offset}");
        }
    }
}

#[test]
fn objects_without_a_box_are_never_met_and_statistics_add_up() {
    let mut random = Random::new(12);
    let mut boxes: Vec<Bounds> =
        random.triangles(500, 0.1).into_iter().map(Bounds::of_points).collect();
    boxes[7] = Bounds::EMPTY;
    boxes[8].max.x = f32::INFINITY;
    boxes[9].min.y = f32::NAN;
    for &(name, kind) in Kind::NAMES {
        let nothing = Any::new(kind, &[], &Parameters::default()).statistics();
        assert_eq!((nothing.references, nothing.sah), (0, 0.0), "{name}");
        let study = Any::new(kind, &boxes, &Parameters::default());
        let of = study.statistics();
        assert_eq!(of.objects, 500, "{name}");
        assert!(of.references >= 497 && of.bytes_of_building >= of.bytes, "{name}: {of:?}");
        assert_eq!(of.leaf_sizes.iter().sum::<u64>(), of.leaves, "{name}");
        assert_eq!(of.leaf_sizes[0], of.empty_leaves, "{name}");
        assert!(of.mean_depth <= f64::from(of.deepest) && of.sah > 0.0, "{name}: {of:?}");
        let ray =
            Ray { origin: -glam::Vec3::ONE, direction: glam::Vec3::ONE, t_max: f32::INFINITY };
        let (mut counts, mut met) = (Counts::default(), vec![]);
        let mut memory = Memory::default();
        let end = study.walk(&ray, &mut memory, &mut counts, |object, t| {
            met.push(object);
            t
        });
        assert_eq!(end, f32::INFINITY);
        assert_eq!(counts.tests, met.len() as u64, "{name}");
        assert!(counts.leaves <= counts.steps && counts.empty_leaves <= counts.leaves, "{name}");
        assert!(!met.iter().any(|object| (7..10).contains(object)), "{name}");
        // A negative answer ends the walk.
        let mut calls = 0;
        study.walk(&ray, &mut memory, &mut (), |_, _| {
            calls += 1;
            -1.0
        });
        assert_eq!(calls, 1, "{name}");
    }
}

/// Restarts bring a ray to the same leaves, in the same order, as a stack does.
#[test]
fn all_ways_through_a_kd_tree_visit_the_same_leaves() {
    let mut random = Random::new(13);
    let boxes: Vec<Bounds> =
        random.triangles(2000, 0.2).into_iter().map(Bounds::of_points).collect();
    let rays = random.rays(500, 1.0);
    let mut memory = Memory::default();
    let mut walk = |traversal| {
        let parameters = Parameters { traversal, ..Parameters::default() };
        let tree = Kd::build(&boxes, &parameters);
        let (mut met, mut totals) = (vec![], Totals::default());
        for i in 0..rays.len() {
            let (origin, direction) = (rays.origin(i), rays.direction(i));
            let ray = Ray { origin, direction, t_max: rays.t_max[i] };
            let mut counts = Counts::default();
            let end = tree.walk(&ray, &mut memory, &mut counts, |object, t_max| {
                met.push(object);
                // The end comes nearer now and then, as it does when objects are hit.
                if object % 97 == 0 { t_max.min(2.0) * 0.75 } else { t_max }
            });
            totals.add(counts, end < rays.t_max[i]);
        }
        (met, totals)
    };
    let (expected, with_stack) = walk(Traversal::Stack);
    assert!(expected.len() > 10_000 && with_stack.sum.restarts == 0);
    let [again, down, short] = [Traversal::Restart, Traversal::PushDown, Traversal::ShortStack]
        .map(|traversal| {
            let (met, totals) = walk(traversal);
            assert_eq!(met, expected, "{traversal:?}");
            assert_eq!(
                [totals.hits, totals.sum.leaves, totals.sum.empty_leaves],
                [with_stack.hits, with_stack.sum.leaves, with_stack.sum.empty_leaves]
            );
            totals.sum
        });
    assert!(again.steps > down.steps && down.steps > short.steps);
    assert!(short.steps > with_stack.sum.steps && short.restarts > 0);
    assert!(short.restarts < down.restarts / 3, "{} {}", short.restarts, down.restarts);
    assert!(down.restarts <= again.restarts);
}

#[test]
fn mailboxes_save_tests_and_nothing_else() {
    let mut random = Random::new(14);
    let boxes: Vec<Bounds> =
        random.triangles(1000, 0.4).into_iter().map(Bounds::of_points).collect();
    let rays = random.rays(300, 1.0);
    for kind in [Kind::Grid, Kind::Octree, Kind::Kd] {
        let count = |mailbox| {
            let parameters = Parameters { mailbox, ..Parameters::default() };
            let study = Any::new(kind, &boxes, &parameters);
            let (mut counts, mut memory) = (Counts::default(), Memory::default());
            for i in 0..rays.len() {
                let (origin, direction) = (rays.origin(i), rays.direction(i));
                let ray = Ray { origin, direction, t_max: rays.t_max[i] };
                study.walk(&ray, &mut memory, &mut counts, |_, t| t);
            }
            counts
        };
        let (without, with) = (count(false), count(true));
        assert!(without.mailbox_hits == 0 && with.mailbox_hits > 0, "{kind:?}");
        assert_eq!(without.tests, with.tests + with.mailbox_hits, "{kind:?}");
        assert_eq!((without.steps, without.leaves), (with.steps, with.leaves), "{kind:?}");
    }
}

/// What each builder is known by.
#[test]
fn hierarchies_are_as_their_papers_say() {
    let mut random = Random::new(15);
    let triangles = random.triangles(1000, 0.05);
    let boxes: Vec<Bounds> = triangles.into_iter().map(Bounds::of_points).collect();
    let of = |kind, parameters| Any::new(kind, &boxes, &parameters).statistics();
    let usual = Parameters::default();
    let median = of(Kind::MedianTree, Parameters { leaf: Some(1), ..usual });
    assert_eq!((median.leaves, median.interior, median.deepest), (1000, 999, 10));
    let rtree = of(Kind::RTree, Parameters { capacity: Some(10), ..usual });
    // ceil(1000 / 10) leaves, packed to the last: 5 slabs and 5 runs do not divide 100 evenly.
    assert!((100..=125).contains(&rtree.leaves), "{}", rtree.leaves);
    assert_eq!((rtree.deepest, rtree.largest_leaf), (2, 10));
    let binary = of(Kind::BinaryTree, usual);
    assert_eq!(binary.references, 1000);
    assert!(binary.sah < median.sah && binary.sah < rtree.sah);
    // A square beneath small balls.
    let balls = scenes::balls();
    let sah = |kind| Any::new(kind, &balls, &usual).statistics().sah;
    let [binary, kd] = [Kind::BinaryTree, Kind::Kd].map(sah);
    let [median, rtree, boxes] = [Kind::MedianTree, Kind::RTree, Kind::Boxes].map(sah);
    let all = [binary, kd, median, rtree, boxes];
    assert!(binary < 0.8 * median && binary < 0.8 * rtree && kd < median, "{all:?}");
    // 1000 boxes, each a step of the list.
    assert_eq!(of(Kind::Boxes, usual).leaves, 1000);
}

/// Two squares that overlap by halves: each has half of its surface in the other's leaf.
#[test]
fn overlap_of_end_points_is_as_computed_by_hand() {
    let corner = |x: u8, y: u8| glam::Vec3::new(f32::from(x), f32::from(y), 0.0);
    let square = |x: u8| {
        let [a, b] = [corner(x, 0), corner(x + 2, 0)];
        let [c, d] = [corner(x + 2, 1), corner(x, 1)];
        [[a, b, c], [a, c, d]]
    };
    let squares = [square(0), square(1)];
    let boxes = squares.map(|square| Bounds::of_points(square.into_iter().flatten()));
    let surfaces: Vec<_> = (0u32..)
        .zip(squares)
        .flat_map(|(object, square)| square.map(|triangle| (object, triangle)))
        .collect();
    for kind in [Kind::MedianTree, Kind::BinaryTree] {
        let parameters = Parameters { leaf: Some(1), ..Parameters::default() };
        let study = Any::new(kind, &boxes, &parameters);
        let overlap = study.end_point_overlap(&surfaces).expect("a hierarchy");
        // (1 + 1) of an area of 4; in one leaf together, nothing is foreign.
        let expected = if study.statistics().leaves == 2 { 0.5 } else { 0.0 };
        assert!((overlap - expected).abs() < 1e-12, "{kind:?}: {overlap}");
    }
    let grid = Any::new(Kind::Grid, &boxes, &Parameters::default());
    assert_eq!(grid.end_point_overlap(&surfaces), None);
}
