//! How fast instances are built and rays are traced through them: `cargo bench --bench copies`.
//!
//! Throughput is placements or rays per second on one thread. On a part of the rays, instances must
//! first agree with a structure over all copies, written out.

use std::hint::black_box;
use std::sync::Arc;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::{Mat3, Vec3};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use slo_accel::instances::{Affine, Child, Placements};
use slo_accel::{
    Accelerator, Coherence, Hits, Instances, InstancesScratch, Isa, NO_HIT, Rays, Scratch,
    Structure, Triangle,
};

/// Rays of one call.
const BATCH: usize = 1024;

/// Calls that are timed together.
const BATCHES: usize = 16;

/// Copies on each side of a field.
const SIDE: usize = 50;

/// How far a distance may be off: roundings of the way to the copy.
const TOLERANCE: f32 = 1e-4;

/// How many rays may hit an edge here and miss it there.
const DOUBTFUL: usize = 2;

/// A ring of 864 triangles.
fn mesh() -> Vec<Triangle> {
    const AROUND: usize = 36;
    const ACROSS: usize = 12;
    let point = |i: usize, j: usize| {
        let (s, c) = libm::sincosf(std::f32::consts::TAU * (i % AROUND) as f32 / AROUND as f32);
        let (t, k) = libm::sincosf(std::f32::consts::TAU * (j % ACROSS) as f32 / ACROSS as f32);
        let radius = 0.3 + 0.1 * k;
        Vec3::new(radius * c, radius * s, 0.1 * t)
    };
    let mut triangles = vec![];
    for i in 0..AROUND {
        for j in 0..ACROSS {
            let (p, q, r, s) = (point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1));
            triangles.extend([[p, q, r], [p, r, s]]);
        }
    }
    triangles
}

/// A field of copies, turned at random.
fn field(rng: &mut StdRng) -> Placements {
    let mut placements = Placements::with_capacity(SIDE * SIDE);
    for i in 0..SIDE * SIDE {
        let axis = Vec3::new(rng.random(), rng.random(), 1.0).normalize();
        let turn = Mat3::from_axis_angle(axis, rng.random_range(0.0..6.0));
        let matrix = turn * Mat3::from_diagonal(Vec3::splat(rng.random_range(0.7..1.5)));
        let translation = Vec3::new((i % SIDE) as f32, (i / SIDE) as f32, 0.5);
        placements.push(0, &[Affine { matrix, translation }]);
    }
    placements
}

fn instances(placements: &Placements) -> Instances {
    let child = Structure::build(Accelerator::Bvh, mesh(), Isa::best());
    let children = vec![Child::Structure(Arc::new(child))];
    Instances::build(children, placements.clone(), Isa::best()).expect("all maps have inverses")
}

/// Camera rays, 16 to a pixel, and rays from anywhere to anywhere.
fn kinds(rng: &mut StdRng) -> [(&'static str, Coherence, Vec<Rays>); 2] {
    let size = SIDE as f32;
    let eye = Vec3::new(0.5 * size, -0.2 * size, 0.3 * size);
    let mut anywhere =
        |height: f32| Vec3::new(rng.random_range(0.0..size), rng.random_range(0.0..size), height);
    let (mut camera, mut bounce) = (vec![], vec![]);
    for _ in 0..BATCHES {
        let (mut from_eye, mut from_surface) = (Rays::default(), Rays::default());
        for _ in 0..BATCH / 16 {
            let pixel = anywhere(0.5);
            for _ in 0..16 {
                let aim = pixel.lerp(anywhere(0.5), 0.1 / size);
                from_eye.push(eye, aim - eye, f32::INFINITY);
                let from = anywhere(1.0);
                from_surface.push(from, anywhere(0.0) - from, f32::INFINITY);
            }
        }
        camera.push(from_eye);
        bounce.push(from_surface);
    }
    [("camera", Coherence::Coherent, camera), ("bounce", Coherence::Incoherent, bounce)]
}

/// Holds instances against one structure over all copies.
fn check(instances: &Instances, placements: &Placements, rays: &Rays) {
    let mesh = mesh();
    let copies = (0..placements.len() as u32).map(|i| placements.pose(i, 0.0));
    let flat = copies.flat_map(|pose| mesh.iter().map(|t| t.map(|p| pose.point(p))));
    let flat = Structure::build(Accelerator::Bvh, flat.collect::<Vec<_>>(), Isa::best());
    let (mut hits, mut expected, mut instance) = (Hits::default(), Hits::default(), vec![]);
    let (coherence, time) = (Coherence::Incoherent, vec![0.0; rays.len()]);
    flat.intersect(rays, coherence, &mut expected, &mut Scratch::default());
    let scratch = &mut InstancesScratch::default();
    instances.intersect(rays, &time, coherence, &mut hits, &mut instance, scratch);
    let differs = |i: &usize| {
        let (found, there) = (hits.primitive[*i] != NO_HIT, expected.primitive[*i] != NO_HIT);
        found != there || (found && (hits.t[*i] - expected.t[*i]).abs() > TOLERANCE)
    };
    let differing = (0..rays.len()).filter(differs).count();
    assert!(differing <= DOUBTFUL, "{differing} rays differ");
}

fn build(c: &mut Criterion) {
    let placements = field(&mut StdRng::seed_from_u64(1));
    let mut group = c.benchmark_group("build copies");
    group.throughput(Throughput::Elements(placements.len() as u64)).sample_size(10);
    group.bench_function("field", |b| b.iter(|| black_box(instances(&placements))));
}

fn trace(c: &mut Criterion) {
    let mut rng = StdRng::seed_from_u64(1);
    let placements = field(&mut rng);
    let instances = instances(&placements);
    for (name, coherence, batches) in kinds(&mut rng) {
        check(&instances, &placements, &batches[0]);
        let mut group = c.benchmark_group(name);
        group.throughput(Throughput::Elements((BATCH * BATCHES) as u64)).sample_size(10);
        let (mut hits, mut instance, mut blocked) = (Hits::default(), vec![], vec![]);
        let (time, mut scratch) = ([0.0; BATCH], InstancesScratch::default());
        group.bench_function("first hits", |b| {
            b.iter(|| {
                for rays in &batches {
                    let out = (&mut hits, &mut instance);
                    instances.intersect(rays, &time, coherence, out.0, out.1, &mut scratch);
                }
                black_box(&hits);
            });
        });
        group.bench_function("any hits", |b| {
            b.iter(|| {
                for rays in &batches {
                    instances.occluded(rays, &time, coherence, &mut blocked, &mut scratch);
                }
                black_box(&blocked);
            });
        });
    }
}

criterion_group!(benches, build, trace);
criterion_main!(benches);
