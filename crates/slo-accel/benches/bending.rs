//! How fast triangles that bend are built and traced: `cargo bench --bench bending`.
//!
//! Throughput is triangles or rays per second on one thread. Every instruction set must first give
//! the hits of triangles at each ray's time, one by one.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::Vec3;
use rand::{RngExt, SeedableRng, rngs::StdRng};
use slo_accel::triangle::{ShearedRay, intersect};
use slo_accel::{Bending, Coherence, Hits, Isa, NO_HIT, Rays, Scratch, Triangle};

/// Rays of one call.
const BATCH: usize = 1024;

/// Calls that are timed together.
const BATCHES: usize = 16;

/// How many rays are held against all triangles.
const CHECKED: usize = 64;

/// A cloth of about 50 thousand triangles, from -1 to 1, at a phase of its waves.
fn cloth(phase: f32) -> Vec<Triangle> {
    const N: usize = 160;
    let point = |i: usize, j: usize| {
        let (x, y) = (i as f32 / N as f32 * 2.0 - 1.0, j as f32 / N as f32 * 2.0 - 1.0);
        let z = 0.15 * libm::sinf(5.0 * x + 3.0 * y + phase)
            + 0.05 * libm::sinf(15.0 * y - 9.0 * x + 2.0 * phase);
        Vec3::new(x + 0.05 * libm::sinf(3.0 * y + phase), y, z)
    };
    let mut triangles = vec![];
    for i in 0..N {
        for j in 0..N {
            let [a, b] = [point(i, j), point(i + 1, j)];
            let [c, d] = [point(i + 1, j + 1), point(i, j + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    triangles
}

/// Rays of one kind, in batches, each with its time.
struct Kind {
    name: &'static str,
    coherence: Coherence,
    batches: Vec<(Rays, Vec<f32>)>,
}

/// Random numbers in `[0, 1)`.
type Unit<'a> = &'a mut dyn FnMut() -> f32;

/// Camera rays, 16 to a pixel, and rays between any points about the cloth.
fn kinds() -> [Kind; 2] {
    let mut rng = StdRng::seed_from_u64(1);
    let mut unit = || rng.random::<f32>();
    let mut batches = |ray: &mut dyn FnMut(usize, Unit<'_>) -> [Vec3; 2]| {
        let batch = |first: usize, unit: Unit<'_>| {
            let (mut rays, mut times) = (Rays::with_capacity(BATCH), vec![]);
            for i in first..first + BATCH {
                let [origin, direction] = ray(i, unit);
                rays.push(origin, direction, f32::INFINITY);
                times.push(unit());
            }
            (rays, times)
        };
        let mut batch = batch;
        (0..BATCHES).map(|k| batch(k * BATCH, &mut unit)).collect()
    };
    let eye = Vec3::new(0.3, -2.2, 1.9);
    let camera = batches(&mut |i, unit| {
        let (x, y) = ((i / 16 % 32) as f32 + unit(), (i / 512) as f32 + unit());
        [eye, Vec3::new(x / 32.0 * 1.8 - 0.9, y / 32.0 * 1.8 - 0.9, 0.0) - eye]
    });
    let any = batches(&mut |_, unit| {
        let mut point = || Vec3::new(unit() - 0.5, unit() - 0.5, (unit() - 0.5) * 0.5) * 2.0;
        let (from, to) = (point(), point());
        [from, to - from]
    });
    [
        Kind { name: "primary", coherence: Coherence::Coherent, batches: camera },
        Kind { name: "any", coherence: Coherence::Incoherent, batches: any },
    ]
}

/// Asks for the hits of all triangles at the times of some rays.
fn check(bending: &Bending, kind: &Kind) {
    let (rays, times) = &kind.batches[0];
    let (mut hits, mut scratch) = (Hits::default(), Scratch::default());
    bending.intersect(rays, times, kind.coherence, &mut hits, &mut scratch);
    for (i, &time) in times.iter().enumerate().take(CHECKED) {
        let ray = ShearedRay::new(rays.origin(i), rays.direction(i));
        let (mut t, mut best) = (f32::INFINITY, NO_HIT);
        for id in 0..bending.triangle_count() as u32 {
            if let Some(hit) = intersect(&ray, &bending.triangle(id, time), t) {
                (t, best) = (hit.t, id);
            }
        }
        assert_eq!((hits.t[i], hits.primitive[i]), (t, best), "{} ray {i}", kind.name);
    }
}

fn bench(criterion: &mut Criterion) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("one thread");
    let shapes = [cloth(0.0), cloth(0.5)];
    let kinds = kinds();
    for isa in Isa::available() {
        let build = || pool.install(|| Bending::build(&shapes, &[0.0, 1.0], isa));
        let bending = build();
        kinds.iter().for_each(|kind| check(&bending, kind));
        let mut group = criterion.benchmark_group(format!("bending, {isa}"));
        group.sample_size(10);
        group.throughput(Throughput::Elements(shapes[0].len() as u64));
        group.bench_function("build", |b| b.iter(build));
        group.throughput(Throughput::Elements((BATCH * BATCHES) as u64));
        for kind in &kinds {
            let (mut hits, mut scratch) = (Hits::default(), Scratch::default());
            group.bench_function(kind.name, |b| {
                b.iter(|| {
                    for (rays, times) in &kind.batches {
                        bending.intersect(rays, times, kind.coherence, &mut hits, &mut scratch);
                        black_box(&hits);
                    }
                });
            });
        }
    }
}

criterion_group!(benches, bench);
criterion_main!(benches);
