//! How fast structures are built and rays are traced: `cargo bench --bench rays`.
//!
//! Throughput is triangles or rays per second on one thread. Every structure and instruction set
//! must first give the hits of brute force, bit by bit, on a part of the rays.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::Vec3;
use rand::{RngExt, SeedableRng, rngs::StdRng};
use slo_accel::{
    Accelerator, BuildOptions, Coherence, Hits, Isa, NO_HIT, Rays, Scratch, Structure, Triangle,
};

/// Rays of one call.
const BATCH: usize = 1024;

/// Calls that are timed together.
const BATCHES: usize = 16;

/// How many rays are held against brute force.
const CHECKED: usize = 64;

/// A floor with a lattice of rings upon it, about 60 thousand triangles, within 10 units.
fn scene() -> Vec<Triangle> {
    const AROUND: usize = 36;
    const ACROSS: usize = 12;
    let mut triangles = vec![];
    let [a, b, c, d] = [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]];
    let floor = [a, b, c, d].map(|[x, y]| Vec3::new(x, y, 0.0));
    triangles.extend([[floor[0], floor[1], floor[2]], [floor[0], floor[2], floor[3]]]);
    for place in 0..70 {
        let center = Vec3::new((place % 10) as f32 - 4.5, (place / 10) as f32 - 3.0, 0.35);
        let lean = 0.1 * place as f32;
        let point = |i: usize, j: usize| {
            let (s, c) = libm::sincosf(std::f32::consts::TAU * (i % AROUND) as f32 / AROUND as f32);
            let (t, k) = libm::sincosf(std::f32::consts::TAU * (j % ACROSS) as f32 / ACROSS as f32);
            let radius = 0.3 + 0.1 * k;
            let flat = Vec3::new(radius * c, radius * s, 0.1 * t);
            let (sin, cos) = libm::sincosf(lean);
            center + Vec3::new(flat.x, flat.y * cos - flat.z * sin, flat.y * sin + flat.z * cos)
        };
        for i in 0..AROUND {
            for j in 0..ACROSS {
                let [p, q] = [point(i, j), point(i + 1, j)];
                let [r, s] = [point(i + 1, j + 1), point(i, j + 1)];
                triangles.extend([[p, q, r], [p, r, s]]);
            }
        }
    }
    triangles
}

/// A kind of ray, as a renderer makes them.
struct Kind {
    name: &'static str,
    any_hit: bool,
    coherence: Coherence,
    batches: Vec<Rays>,
}

/// Camera rays, 16 to a pixel; shadow rays from their hits to a light; directions from there into
/// the half space above; the same again from where those arrive.
fn kinds(structure: &Structure) -> Vec<Kind> {
    let mut rng = StdRng::seed_from_u64(1);
    let mut unit = || rng.random::<f32>();
    let eye = Vec3::new(0.0, -8.0, 5.0);
    let camera: Vec<_> = (0..BATCH * BATCHES)
        .map(|i| {
            let (x, y) = ((i / 16 % 32) as f32 + unit(), (i / 512) as f32 + unit());
            let aim = Vec3::new(x / 32.0 * 9.0 - 4.5, y / 32.0 * 9.0 - 4.5, 0.3);
            (eye, (aim - eye).normalize(), f32::INFINITY)
        })
        .collect();
    let mut around = |points: &[Vec3]| -> Vec<_> {
        let mut direction = || {
            let v = Vec3::new(unit() - 0.5, unit() - 0.5, unit() * 0.5);
            v.normalize_or(Vec3::Z)
        };
        points.iter().map(|&p| (p, direction(), f32::INFINITY)).collect()
    };
    let first = arrivals(structure, &camera);
    let bounce = around(&first);
    let second = around(&arrivals(structure, &bounce));
    let light = Vec3::new(3.0, -2.0, 8.0);
    let shadow: Vec<_> = first.iter().map(|&p| (p, light - p, 1.0)).collect();
    let kind = |name, any_hit, coherence, rays: &[_]| Kind {
        name,
        any_hit,
        coherence,
        batches: batches(rays),
    };
    vec![
        kind("primary", false, Coherence::Coherent, &camera),
        kind("shadow", true, Coherence::Coherent, &shadow),
        kind("bounce 1", false, Coherence::Incoherent, &bounce),
        kind("bounce 2", false, Coherence::Incoherent, &second),
    ]
}

type Ray = (Vec3, Vec3, f32);

fn batches(rays: &[Ray]) -> Vec<Rays> {
    let batch = |rays: &[Ray]| {
        let mut batch = Rays::with_capacity(BATCH);
        rays.iter().for_each(|&(origin, direction, t_max)| batch.push(origin, direction, t_max));
        batch
    };
    rays.chunks(BATCH).map(batch).collect()
}

/// Points just before what rays hit; where they hit nothing, their origins.
fn arrivals(structure: &Structure, rays: &[Ray]) -> Vec<Vec3> {
    let (mut hits, mut scratch) = (Hits::default(), Scratch::default());
    let mut points = vec![];
    for (batch, rays) in batches(rays).iter().zip(rays.chunks(BATCH)) {
        structure.intersect(batch, Coherence::Incoherent, &mut hits, &mut scratch);
        points.extend(rays.iter().enumerate().map(|(i, &(origin, direction, _))| {
            let is_hit = hits.primitive[i] != NO_HIT;
            if is_hit { origin + direction * (hits.t[i] * 0.999) } else { origin }
        }));
    }
    points
}

/// Answers that can be compared.
fn answers(structure: &Structure, kind: &Kind, rays: &Rays) -> (Vec<[u32; 4]>, Vec<bool>) {
    let (mut hits, mut blocked, mut scratch) = (Hits::default(), vec![], Scratch::default());
    structure.intersect(rays, kind.coherence, &mut hits, &mut scratch);
    structure.occluded(rays, kind.coherence, &mut blocked, &mut scratch);
    let bits = |i: usize| {
        [hits.t[i].to_bits(), hits.u[i].to_bits(), hits.v[i].to_bits(), hits.primitive[i]]
    };
    ((0..CHECKED).map(bits).collect(), blocked[..CHECKED].to_vec())
}

/// Structures that are measured: their names, and whether they have spatial splits.
const WAYS: [(&str, Accelerator, bool); 4] = [
    ("BVH", Accelerator::Bvh, false),
    ("BVH with spatial splits", Accelerator::Bvh, true),
    ("KDTREE", Accelerator::KdTree, false),
    ("CWBVH", Accelerator::Cwbvh, false),
];

fn structures(triangles: &[Triangle]) -> Vec<(String, Structure)> {
    let mut all = vec![];
    for (name, accelerator, spatial_splits) in WAYS {
        for isa in Isa::available() {
            let options = BuildOptions::new(isa).with_spatial_splits(spatial_splits);
            let structure = Structure::build(accelerator, triangles.to_vec(), options);
            all.push((format!("{name} {isa:?}"), structure));
        }
    }
    all
}

fn build(c: &mut Criterion) {
    let triangles = scene();
    let mut group = c.benchmark_group("build");
    group.throughput(Throughput::Elements(triangles.len() as u64)).sample_size(10);
    for (name, accelerator, spatial_splits) in WAYS {
        let options = BuildOptions::new(Isa::best()).with_spatial_splits(spatial_splits);
        group.bench_function(name, |b| {
            b.iter(|| black_box(Structure::build(accelerator, triangles.clone(), options)));
        });
    }
}

fn trace(c: &mut Criterion) {
    let triangles = scene();
    let structures = structures(&triangles);
    let oracle = Structure::build(Accelerator::None, triangles, Isa::best());
    for kind in kinds(&structures[0].1) {
        let mut group = c.benchmark_group(kind.name);
        group.throughput(Throughput::Elements((BATCH * BATCHES) as u64)).sample_size(10);
        let mut checked = Rays::default();
        for i in 0..CHECKED {
            let rays = &kind.batches[i % BATCHES];
            checked.push(rays.origin(i), rays.direction(i), rays.t_max[i]);
        }
        let expected = answers(&oracle, &kind, &checked);
        for (name, structure) in &structures {
            assert!(answers(structure, &kind, &checked) == expected, "{name}, {}", kind.name);
            let (mut hits, mut blocked) = (Hits::default(), vec![]);
            let mut scratch = Scratch::default();
            group.bench_function(name.as_str(), |b| {
                b.iter(|| {
                    for rays in &kind.batches {
                        if kind.any_hit {
                            structure.occluded(rays, kind.coherence, &mut blocked, &mut scratch);
                            black_box(&blocked);
                        } else {
                            structure.intersect(rays, kind.coherence, &mut hits, &mut scratch);
                            black_box(&hits);
                        }
                    }
                });
            });
        }
    }
}

criterion_group!(benches, build, trace);
criterion_main!(benches);
