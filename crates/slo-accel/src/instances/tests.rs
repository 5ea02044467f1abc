//! Instances against brute force over the same places, one by one.

use std::sync::Arc;

use glam::{DMat3, DVec3, Mat3, Vec3};
use rand::RngExt;

use super::*;
use crate::primitives::{Primitives, Triangle};
use crate::rays::{Coherence, Hits, NO_HIT, Rays};
use crate::structure::testing::Random;
use crate::structure::{Accelerator, Scratch};

/// t, u, v, primitive, and instance of a hit, as bits.
type Bits = [u32; 5];

fn affine(random: &mut Random, scale: f32) -> Affine {
    let axis = random.vector(1.0).normalize_or(Vec3::Z);
    let turn = Mat3::from_axis_angle(axis, random.0.random_range(0.0..6.0));
    let sides = Vec3::from_array(std::array::from_fn(|_| random.0.random_range(0.3..2.0)));
    Affine { matrix: turn * Mat3::from_diagonal(sides * scale), translation: random.vector(1.0) }
}

fn structure(accelerator: Accelerator, primitives: &Primitives, isa: Isa) -> Child {
    Child::Structure(Arc::new(Structure::build(accelerator, primitives.clone(), isa)))
}

/// Answers of instances: first hits, and which rays are blocked.
fn ask(
    instances: &Instances,
    rays: &Rays,
    time: &[f32],
    coherence: Coherence,
) -> Vec<(Bits, bool)> {
    let (mut hits, mut instance, mut blocked) = (Hits::default(), vec![], vec![]);
    let mut scratch = InstancesScratch::default();
    instances.intersect(rays, time, coherence, &mut hits, &mut instance, &mut scratch);
    instances.occluded(rays, time, coherence, &mut blocked, &mut scratch);
    (0..rays.len()).map(|i| (bits(&hits, i, instance[i]), blocked[i])).collect()
}

fn bits(hits: &Hits, i: usize, instance: u32) -> Bits {
    let [t, u, v] = [hits.t[i], hits.u[i], hits.v[i]].map(f32::to_bits);
    [t, u, v, hits.primitive[i], instance]
}

/// The same without boxes: each ray asks every structure at every place, in the space of the
/// structure, where it is taken by the same maps.
fn one_by_one(instances: &Instances, rays: &Rays, time: &[f32]) -> Vec<(Bits, bool)> {
    let mut scratch = Scratch::default();
    let (mut hits, mut blocked) = (Hits::default(), vec![]);
    let answer = |i: usize| {
        let mut best: Bits = [f32::INFINITY.to_bits(), 0, 0, NO_HIT, NO_INSTANCE];
        for number in 0..instances.count() {
            let (mut origin, mut direction) = (rays.origin(i), rays.direction(i));
            let mut child = None;
            for (level, placement) in instances.chain(number) {
                let pose = level.placements().pose(placement, time[i]);
                (origin, direction) = Inverse::of(pose).expect("invertible").ray(origin, direction);
                child = Some(level.child(placement));
            }
            let mut local = Rays::default();
            local.push(origin, direction, rays.t_max[i]);
            let alike = Coherence::Incoherent;
            match child {
                Some(Child::Structure(structure)) => {
                    structure.intersect(&local, alike, &mut hits, &mut scratch);
                    structure.occluded(&local, alike, &mut blocked, &mut scratch);
                }
                Some(Child::Bending(bending)) => {
                    bending.intersect(&local, &time[i..], alike, &mut hits, &mut scratch);
                    bending.occluded(&local, &time[i..], alike, &mut blocked, &mut scratch);
                }
                _ => panic!("primitives"),
            }
            assert_eq!(blocked[0], hits.primitive[0] != NO_HIT);
            // Bits of positive numbers order as they do.
            if hits.primitive[0] != NO_HIT && hits.t[0].to_bits() < best[0] {
                best = bits(&hits, 0, number);
            }
        }
        (best, best[3] != NO_HIT)
    };
    (0..rays.len()).map(answer).collect()
}

/// Holds instances against [`one_by_one`], for all instruction sets, kinds of children, and sizes of
/// batches; returns how many rays hit something.
fn check(make: &dyn Fn(Accelerator, Isa) -> Instances, rays: &Rays) -> usize {
    let time: Vec<f32> = (0..rays.len()).map(|i| (i % 11) as f32 / 10.0).collect();
    let expected = one_by_one(&make(Accelerator::None, Isa::Portable), rays, &time);
    for isa in Isa::available() {
        for accelerator in [Accelerator::Bvh, Accelerator::KdTree, Accelerator::None] {
            let instances = make(accelerator, isa);
            for coherence in [Coherence::Coherent, Coherence::Incoherent] {
                let answers = ask(&instances, rays, &time, coherence);
                for (i, (answer, expected)) in answers.iter().zip(&expected).enumerate() {
                    let (o, d) = (rays.origin(i), rays.direction(i));
                    assert_eq!(answer, expected, "{accelerator} {isa} {coherence:?} {i} {o} {d}");
                }
            }
            for i in [0, rays.len() / 2, rays.len() - 1] {
                let mut one = Rays::default();
                one.push(rays.origin(i), rays.direction(i), rays.t_max[i]);
                let answer = ask(&instances, &one, &time[i..=i], Coherence::Incoherent);
                assert_eq!(answer[0], expected[i]);
            }
        }
    }
    expected.iter().filter(|(_, is_hit)| *is_hit).count()
}

#[test]
fn copies_are_hit_where_they_are() {
    let mut random = Random::new(1);
    let meshes = [random.triangles(40, 0.5), random.triangles(3, 1.0), vec![]];
    let curved = random.curved(3, 0.4);
    let mut placements = Placements::default();
    for i in 0..50 {
        let poses: Vec<Affine> = (0..1 + i % 3).map(|_| affine(&mut random, 0.3)).collect();
        placements.push(i % 3, &poses);
    }
    let make = |accelerator, isa| {
        let child = |triangles: &Vec<Triangle>| {
            let curved = if triangles.len() == 3 { curved.clone() } else { vec![] };
            structure(accelerator, &Primitives { triangles: triangles.clone(), curved }, isa)
        };
        let children = meshes.iter().map(child).collect();
        Instances::build(children, placements.clone(), isa).expect("they are few")
    };
    assert!(check(&make, &random.rays(2_500, 1.5)) > 500);
    assert!(check(&make, &random.bundles(500, 1.5)) > 100);
}

#[test]
fn copies_of_copies_are_hit_where_they_are() {
    let mut random = Random::new(2);
    let triangles: Primitives = random.triangles(20, 0.5).into();
    let levels: Vec<Placements> = (0..4)
        .map(|level| {
            let mut placements = Placements::default();
            for i in 0..3 {
                let poses: Vec<Affine> = (0..1 + i % 2).map(|_| affine(&mut random, 0.7)).collect();
                placements.push(if level == 0 { 0 } else { i % 2 }, &poses);
            }
            placements
        })
        .collect();
    let make = |accelerator, isa| {
        let mesh = structure(accelerator, &triangles, isa);
        let mut top = Instances::build(vec![mesh.clone()], levels[0].clone(), isa);
        for placements in &levels[1..] {
            let below = Child::Instances(Arc::new(top.expect("they are few")));
            top = Instances::build(vec![below, mesh.clone()], placements.clone(), isa);
        }
        top.expect("they are few")
    };
    let instances = make(Accelerator::Bvh, Isa::best());
    // 3, then twice as many and one, again and again.
    assert_eq!(instances.count(), 31);
    let depths: Vec<usize> = (0..31).map(|number| instances.chain(number).count()).collect();
    assert_eq!((depths[0], depths.iter().min(), depths.iter().max()), (4, Some(&1), Some(&4)));
    assert!(check(&make, &random.rays(2_000, 2.0)) > 300);
}

#[test]
fn some_children_bend() {
    let mut random = Random::new(8);
    let mesh = Primitives::from(random.triangles(30, 0.5));
    let shapes: Vec<Vec<Triangle>> = (0..3).map(|_| random.triangles(30, 0.5)).collect();
    let mut placements = Placements::default();
    for i in 0..40 {
        let poses: Vec<_> = (0..1 + i % 2).map(|_| affine(&mut random, 0.5)).collect();
        placements.push(i % 2, &poses);
    }
    let make = |accelerator, isa| {
        let bending = Bending::build(&shapes, &[0.0, 0.4, 1.0], isa);
        let children = vec![structure(accelerator, &mesh, isa), Child::Bending(Arc::new(bending))];
        Instances::build(children, placements.clone(), isa).expect("it can be built")
    };
    let rays = random.rays(300, 3.0);
    let hits = check(&make, &rays);
    assert!(hits > 50, "{hits}");
}

#[test]
fn of_equal_hits_the_lowest_instance_counts() {
    let square = [
        [Vec3::ZERO, Vec3::X, Vec3::ONE.with_z(0.0)],
        [Vec3::ZERO, Vec3::ONE.with_z(0.0), Vec3::Y],
    ];
    let mut random = Random::new(3);
    let mut placements = Placements::default();
    for i in 0..40 {
        // Steps that are exact, so that squares lie upon each other.
        let shift = Vec3::from_array(std::array::from_fn(|_| random.0.random_range(-2..3) as f32));
        let matrix = Mat3::from_diagonal(Vec3::splat([1.0, 2.0][i % 2]));
        placements.push((i % 2) as u32, &[Affine { matrix, translation: shift * 0.5 }]);
    }
    let make = |accelerator, isa| {
        let mesh = structure(accelerator, &square.to_vec().into(), isa);
        let mut pair = Placements::default();
        (0..2).for_each(|_| pair.push(0, &[Affine::IDENTITY]));
        let pair = Instances::build(vec![mesh.clone()], pair, isa).expect("they are few");
        let children = vec![mesh, Child::Instances(Arc::new(pair))];
        Instances::build(children, placements.clone(), isa).expect("they are few")
    };
    let mut rays = Rays::default();
    for _ in 0..1_000 {
        let at = random.vector(2.0).with_z(3.0);
        rays.push(at, Vec3::NEG_Z, [f32::INFINITY, 2.0, 3.0][rays.len() % 3]);
    }
    assert!(check(&make, &rays) > 200);
}

#[test]
fn rays_and_places_of_any_size() {
    let mut random = Random::new(4);
    let triangles: Primitives = random.triangles(30, 0.5).into();
    for scale in [1e-12, 1e-5, 1e12, 1e19] {
        let mut placements = Placements::default();
        for _ in 0..10 {
            let map = affine(&mut random, 0.4);
            let matrix = map.matrix * scale;
            placements.push(0, &[Affine { matrix, translation: map.translation * scale }]);
        }
        let make = |accelerator, isa| {
            let mesh = structure(accelerator, &triangles, isa);
            Instances::build(vec![mesh], placements.clone(), isa).expect("they are few")
        };
        let hit = check(&make, &random.rays(300, scale));
        assert!(hit > 30, "{scale}: {hit}");
    }
}

/// A hit is found within a few roundings of the triangle that was flattened in f64.
#[test]
fn hits_lie_on_flattened_triangles() {
    let mut random = Random::new(5);
    let triangles = random.triangles(50, 0.4);
    let mut placements = Placements::default();
    let far = Vec3::new(300.0, -200.0, 100.0);
    for _ in 0..100 {
        let map = affine(&mut random, 0.3);
        placements.push(0, &[Affine { translation: map.translation + far, ..map }]);
    }
    let mesh = structure(Accelerator::Bvh, &triangles.clone().into(), Isa::best());
    let instances =
        Instances::build(vec![mesh], placements.clone(), Isa::best()).expect("they are few");
    let mut rays = random.rays(3_000, 1.0);
    for i in 0..rays.len() {
        (0..3).for_each(|axis| rays.origin[axis][i] += far[axis]);
    }
    let (mut hits, mut instance) = (Hits::default(), vec![]);
    let time = vec![0.0; rays.len()];
    let scratch = &mut InstancesScratch::default();
    let coherence = Coherence::Incoherent;
    instances.intersect(&rays, &time, coherence, &mut hits, &mut instance, scratch);
    let mut found = 0;
    for i in (0..rays.len()).filter(|&i| hits.primitive[i] != NO_HIT) {
        let pose = placements.pose(instance[i], 0.0);
        let matrix: DMat3 = pose.matrix.as_dmat3();
        let corner = |p: Vec3| matrix * p.as_dvec3() + pose.translation.as_dvec3();
        let [a, b, c] = triangles[hits.primitive[i] as usize].map(corner);
        let (u, v) = (f64::from(hits.u[i]), f64::from(hits.v[i]));
        let on_triangle = a + (b - a) * u + (c - a) * v;
        let (o, d): (DVec3, DVec3) = (rays.origin(i).as_dvec3(), rays.direction(i).as_dvec3());
        let on_ray = o + d * f64::from(hits.t[i]);
        // Roundings of the distance from the ray's origin to the instance, not of `far`.
        let reach = 2.0 * (o - pose.translation.as_dvec3()).abs().max_element() + 1.0;
        let error = (on_triangle - on_ray).abs().max_element() / reach;
        assert!(error < 130.0 * f64::from(crate::math::rounding::UNIT_ROUNDOFF), "{error:e}");
        found += 1;
    }
    assert!(found > 500, "{found}");
}

#[test]
fn hits_of_other_things_end_rays() {
    let mut random = Random::new(6);
    let mesh = structure(Accelerator::Bvh, &random.triangles(50, 0.6).into(), Isa::best());
    let mut placements = Placements::default();
    (0..9).for_each(|_| placements.push(0, &[affine(&mut random, 0.4)]));
    let instances = Instances::build(vec![mesh], placements, Isa::best()).expect("they are few");
    let rays = random.rays(1_000, 1.0);
    let time = vec![0.5; rays.len()];
    let expected = ask(&instances, &rays, &time, Coherence::Incoherent);
    let (mut hits, mut instance, mut scratch) =
        (Hits::default(), vec![], InstancesScratch::default());
    hits.reset(rays.len());
    let mut reach = rays.t_max.clone();
    for i in 0..rays.len() {
        reach[i] = reach[i].min([f32::INFINITY, 0.4, -1.0][i % 3]);
        hits.t[i] = reach[i];
    }
    let mut blocked = vec![false; rays.len().next_multiple_of(crate::LANES)];
    let coherence = Coherence::Incoherent;
    instances.intersect_within(
        &rays,
        &time,
        &reach,
        coherence,
        &mut hits,
        &mut instance,
        &mut scratch,
    );
    instances.occluded_within(&rays, &time, &reach, coherence, &mut blocked, &mut scratch);
    for (i, (expected, _)) in expected.iter().enumerate() {
        let counts = f32::from_bits(expected[0]) < reach[i];
        let other = [reach[i].to_bits(), 0, 0, NO_HIT, NO_INSTANCE];
        assert_eq!(bits(&hits, i, instance[i]), if counts { *expected } else { other });
        assert_eq!(blocked[i], counts);
    }
}

#[test]
fn what_cannot_be_built_is_told() {
    let mesh =
        || structure(Accelerator::Bvh, &Random::new(7).triangles(2, 1.0).into(), Isa::best());
    let mut one = Placements::default();
    one.push(0, &[Affine::IDENTITY]);
    let mut deep = mesh();
    for _ in 0..MAX_DEPTH {
        let instances = Instances::build(vec![deep], one.clone(), Isa::best()).expect("not deep");
        deep = Child::Instances(Arc::new(instances));
    }
    let error = Instances::build(vec![deep], one.clone(), Isa::best()).expect_err("too deep");
    assert_eq!(error, BuildError::TooDeep);
    let mut flat = one.clone();
    flat.push(0, &[Affine { matrix: Mat3::from_diagonal(Vec3::X), ..Affine::IDENTITY }]);
    let error = Instances::build(vec![mesh()], flat, Isa::best()).expect_err("flat");
    assert_eq!(error, BuildError::NotInvertible(1));
    let mut many = Placements::default();
    (0..2000).for_each(|_| many.push(0, &[Affine::IDENTITY]));
    let mut all = mesh();
    for _ in 0..2 {
        let instances = Instances::build(vec![all], many.clone(), Isa::best()).expect("few");
        all = Child::Instances(Arc::new(instances));
    }
    let error = Instances::build(vec![all], many, Isa::best()).expect_err("8 000 million");
    assert_eq!(error, BuildError::TooMany);
    let none = Instances::build(vec![], Placements::default(), Isa::best()).expect("nothing");
    assert!(none.count() == 0 && none.bounds().is_empty());
    let rays = Random::new(8).rays(20, 1.0);
    let answers = ask(&none, &rays, &[0.0; 20], Coherence::Coherent);
    assert!(answers.iter().all(|(hit, is_blocked)| hit[3] == NO_HIT && !is_blocked));
}
