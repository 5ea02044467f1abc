//! Measures how fast a million triangles are read: `cargo bench --bench load`.
//!
//! Throughput is in bytes of the file per second, on one thread. There are two files: `short` has
//! six decimals, as exporters write them; `full` has every digit of the f64, and uvs.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::DVec3;
use slo_scene::mesh::slo;
use slo_scene::{Mesh, mesh};

/// Number of quads of the grid, each of two triangles.
const SIZE: [u32; 2] = [1000, 500];

/// A wavy sheet of a million triangles. `digits` rounds its coordinates.
fn sheet(with_uvs: bool, digits: impl Fn(f64) -> f64) -> Mesh {
    let [width, height] = SIZE;
    let mut mesh = Mesh::default();
    for y in 0..=height {
        for x in 0..=width {
            let (u, v) = (f64::from(x) / f64::from(width), f64::from(y) / f64::from(height));
            let z = 0.1 * libm::sin(17.0 * u) * libm::cos(11.0 * v);
            mesh.positions.push(DVec3::new(2.0 * u - 1.0, v - 0.5, z).map(&digits));
            if with_uvs {
                mesh.uvs.push([u as f32, v as f32]);
            }
        }
    }
    for y in 0..height {
        for x in 0..width {
            let a = y * (width + 1) + x;
            let (b, c, d) = (a + 1, a + width + 2, a + width + 1);
            mesh.faces.extend([[a, b, c], [a, c, d]]);
        }
    }
    if with_uvs {
        mesh.face_uvs = mesh.faces.clone();
    }
    mesh
}

/// Writes the mesh as a file, and checks the result of reading it.
fn checked_file(mesh: &Mesh) -> Vec<u8> {
    let mut file = Vec::new();
    slo::write_slo(mesh, &mut file).expect("memory can be written");
    let read = slo::read(&mut file.as_slice()).expect("what was written can be read");
    assert!(read == *mesh, "the file is read back as another mesh");
    file
}

/// Times reading alone, all of loading (degenerate triangles, scale, smooth normals), and writing.
fn bench_load(c: &mut Criterion) {
    let short = sheet(false, |x| libm::round(x * 1e6) / 1e6);
    let full = sheet(true, |x| x);
    for (name, mesh) in [("short", short), ("full", full)] {
        let file = checked_file(&mesh);
        let mut group = c.benchmark_group(format!("slo_1M_triangles_{name}"));
        group.throughput(Throughput::Bytes(file.len() as u64)).sample_size(10);
        group.bench_function("read", |b| b.iter(|| slo::read(&mut black_box(file.as_slice()))));
        group.bench_function("load_smooth", |b| {
            b.iter(|| mesh::load("m.slo", &mut black_box(file.as_slice()), true, 2.5))
        });
        group.bench_function("write", |b| {
            b.iter(|| slo::write_slo(black_box(&mesh), std::io::sink()))
        });
        group.finish();
    }
}

criterion_group!(benches, bench_load);
criterion_main!(benches);
