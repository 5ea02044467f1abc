//! Traces the same rays on the CPU and on the GPU, through the same structures, and prints both in a table.
//!
//! ```text
//! cargo run --release -p slo-gpu --features device --example gpu_rays -- MESH.tri [SIZE] [BATCH]
//! ```
//!
//! A mesh is the number of triangles (u32, little-endian), then nine f32 for each. Without one, a ball of
//! 20 000 triangles is traced. SIZE x SIZE primary rays (P) look at the mesh from its front; each hit sends a
//! shadow ray (PS) to a lamp above, and a reflected ray (PSR). BATCH rays go to the GPU at a time; 0: all.
//!
//! The CPU's time is that of the textbook traversal, on one thread. Hits and counters of both are compared.
//! `SLO_RT_GPU` names the adapter.

use std::process::ExitCode;
use std::time::{Duration, Instant};

use slo_accel::glam::Vec3;
use slo_accel::math::Bounds;
use slo_accel::study::{
    Answer, BinaryTree, Counts, Grid, Kd, Memory, Parameters, Ray, Study, Traversal,
};
use slo_accel::triangle::{self, ShearedRay, TriangleHit};
use slo_accel::{Device, NO_HIT, Rays, Triangle, Uploaded};
use slo_gpu::Gpu;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("gpu_rays: {message}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), String> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |place: usize, usual: usize| match arguments.get(place) {
        Some(text) => text.parse().map_err(|_| format!("`{text}` is no number")),
        None => Ok(usual),
    };
    let (size, batch) = (number(1, 256)?, number(2, 0)?);
    let mut triangles = match arguments.first() {
        Some(path) => read(path)?,
        None => ball(100),
    };
    triangles.retain(|triangle| !triangle::is_degenerate(triangle));
    let gpu = Gpu::open(std::env::var("SLO_RT_GPU").ok().as_deref())?;
    println!("{} triangles, {size} x {size} rays, on {}", triangles.len(), gpu.adapter());
    println!(
        "structure  rays      number    hits      steps     tests  CPU s   GPU s   CPU Mrays/s  GPU Mrays/s  differ  left to CPU"
    );
    let mut short = Parameters::default();
    short.traversal = Traversal::ShortStack;
    let batch = if batch == 0 { usize::MAX } else { batch };
    measure::<Grid>(&gpu, "GRID", &triangles, Parameters::default(), size, batch)?;
    measure::<Kd>(&gpu, "KD", &triangles, short, size, batch)?;
    measure::<BinaryTree>(&gpu, "BINARY", &triangles, Parameters::default(), size, batch)
}

/// A structure on both sides.
struct Both<'a, S> {
    study: S,
    uploaded: Box<dyn Uploaded>,
    triangles: &'a [Triangle],
    batch: usize,
}

fn measure<S: Study>(
    gpu: &Gpu,
    name: &str,
    triangles: &[Triangle],
    parameters: Parameters,
    size: usize,
    batch: usize,
) -> Result<(), String> {
    let boxes: Vec<Bounds> = triangles.iter().map(|&one| Bounds::of_points(one)).collect();
    let study = S::build(&boxes, &parameters);
    let layout = study.layout().ok_or("the GPU does not traverse this structure")?;
    let uploaded = gpu.upload(&layout, triangles)?;
    let both = Both { study, uploaded, triangles, batch };
    let all = boxes.iter().fold(Bounds::EMPTY, |all, one| all.union(*one));
    let primary = primary(&all, size);
    // The first dispatch compiles the program.
    both.uploaded.trace(&primary, false, &mut vec![])?;
    let hits = both.compare(name, "P", &primary, false)?;
    let lamp = all.max + 0.7 * (all.max - all.min);
    let (mut shadow, mut reflected) = (Rays::default(), Rays::default());
    for (i, hit) in hits.iter().enumerate() {
        let Some((object, hit)) = hit else { continue };
        let direction = primary.direction(i);
        let [a, b, c] = triangles[*object as usize];
        let normal = (b - a).cross(c - a).normalize();
        let point = a + hit.u * (b - a) + hit.v * (c - a);
        let away = if normal.dot(direction) > 0.0 { -normal } else { normal };
        let point = point + 1e-5 * (all.max - all.min).max_element() * away;
        shadow.push(point, lamp - point, 1.0);
        reflected.push(point, direction - 2.0 * direction.dot(normal) * normal, f32::INFINITY);
    }
    both.compare(name, "PS", &shadow, true)?;
    both.compare(name, "PSR", &reflected, false)?;
    Ok(())
}

type Found = Option<(u32, TriangleHit)>;

impl<S: Study> Both<'_, S> {
    /// Traces rays on both sides, prints a line of the table, and returns the CPU's hits.
    fn compare(
        &self,
        name: &str,
        kind: &str,
        rays: &Rays,
        any: bool,
    ) -> Result<Vec<Found>, String> {
        let start = Instant::now();
        let mut memory = Memory::default();
        let cpu: Vec<(Found, Counts)> =
            (0..rays.len()).map(|i| self.by_cpu(rays, i, any, &mut memory)).collect();
        let cpu_time = start.elapsed();
        let start = Instant::now();
        let gpu = self.by_gpu(rays, any)?;
        let gpu_time = start.elapsed();
        let mut sum = Counts::default();
        cpu.iter().for_each(|(_, counts)| sum += *counts);
        let hits = cpu.iter().filter(|(hit, _)| hit.is_some()).count();
        let differ =
            cpu.iter().zip(&gpu).filter(|(cpu, gpu)| gpu.is_certain && differs(cpu, gpu)).count();
        let left = gpu.iter().filter(|answer| !answer.is_certain).count();
        let speed = |time: Duration| rays.len() as f64 / time.as_secs_f64() / 1e6;
        println!(
            "{name:10} {kind:4} {:11} {hits:7} {:10} {:9} {:6.3}  {:6.3}  {:11.3}  {:11.3}  {differ:6}  {left:11}",
            rays.len(),
            sum.steps,
            sum.tests,
            cpu_time.as_secs_f64(),
            gpu_time.as_secs_f64(),
            speed(cpu_time),
            speed(gpu_time),
        );
        Ok(cpu.into_iter().map(|(hit, _)| hit).collect())
    }

    fn by_cpu(&self, rays: &Rays, i: usize, any: bool, memory: &mut Memory) -> (Found, Counts) {
        let (origin, direction, t_max) = (rays.origin(i), rays.direction(i), rays.t_max[i]);
        let sheared = ShearedRay::new(origin, direction);
        let (mut best, mut counts) = (None, Counts::default());
        let ray = Ray { origin, direction, t_max };
        self.study.walk(&ray, memory, &mut counts, |object, t_max| {
            let is_lower = best.is_some_and(|(lowest, _)| object < lowest);
            let limit = if is_lower { t_max.next_up() } else { t_max };
            match triangle::intersect(&sheared, &self.triangles[object as usize], limit) {
                Some(hit) => {
                    best = Some((object, hit));
                    if any { f32::NEG_INFINITY } else { hit.t }
                }
                None => t_max,
            }
        });
        (best, counts)
    }

    fn by_gpu(&self, rays: &Rays, any: bool) -> Result<Vec<Answer>, String> {
        let (mut all, mut some, mut part) = (vec![], vec![], Rays::default());
        for start in (0..rays.len()).step_by(self.batch.min(rays.len().max(1))) {
            let end = rays.len().min(start.saturating_add(self.batch));
            part.set_len(0);
            (start..end).for_each(|i| part.push(rays.origin(i), rays.direction(i), rays.t_max[i]));
            self.uploaded.trace(&part, any, &mut some)?;
            all.append(&mut some);
        }
        Ok(all)
    }
}

fn differs((hit, counts): &(Found, Counts), answer: &Answer) -> bool {
    let same = match hit {
        Some((object, hit)) => {
            let bits = [hit.t, hit.u, hit.v].map(f32::to_bits);
            *object == answer.object && bits == [answer.t, answer.u, answer.v].map(f32::to_bits)
        }
        None => answer.object == NO_HIT,
    };
    !same || *counts != answer.counts
}

/// Rays from in front of a box, which fills most of the picture.
fn primary(all: &Bounds, size: usize) -> Rays {
    let (center, extent) = (0.5 * (all.min + all.max), all.max - all.min);
    let eye = center - Vec3::Y * (0.5 * extent.y + 1.5 * extent.max_element());
    let mut rays = Rays::with_capacity(size * size);
    for row in 0..size {
        for column in 0..size {
            let share = |i: usize| (i as f32 + 0.5) / size as f32 - 0.5;
            let across = Vec3::new(share(column), 0.0, share(row)) * (1.1 * extent.max_element());
            rays.push(eye, center + across - eye, f32::INFINITY);
        }
    }
    rays
}

fn read(path: &str) -> Result<Vec<Triangle>, String> {
    let bytes = std::fs::read(path).map_err(|error| format!("{path}: {error}"))?;
    let words: Vec<[u8; 4]> =
        bytes.chunks_exact(4).filter_map(|word| word.try_into().ok()).collect();
    let count = words.first().map_or(0, |&word| u32::from_le_bytes(word) as usize);
    let numbers: Vec<f32> = words.iter().skip(1).map(|&word| f32::from_le_bytes(word)).collect();
    if numbers.len() < 9 * count {
        return Err(format!("{path}: is cut off"));
    }
    let corner = |p: &[f32]| Vec3::new(p[0], p[1], p[2]);
    let triangle = |t: &[f32]| [corner(t), corner(&t[3..]), corner(&t[6..])];
    Ok(numbers.chunks_exact(9).take(count).map(triangle).collect())
}

/// A ball of `2 n n` triangles.
fn ball(n: u32) -> Vec<Triangle> {
    let point = |i: u32, j: u32| {
        let z = 2.0 * i as f32 / n as f32 - 1.0;
        let w = 4.0 * (j % n) as f32 / n as f32;
        // The circle, piece by piece, from its tangents.
        let t = w.fract() * 2.0 - 1.0;
        let turn = t * std::f32::consts::FRAC_1_SQRT_2 / (1.0 + (1.0 - 0.5 * t * t).sqrt());
        let [x, y] = [1.0 - turn * turn, 2.0 * turn].map(|p| p / (1.0 + turn * turn));
        let [x, y] = match w as u32 {
            0 => [x, y],
            1 => [-y, x],
            2 => [-x, -y],
            _ => [y, -x],
        };
        let radius = (1.0 - z * z).max(0.0).sqrt();
        Vec3::new(radius * x, radius * y, z)
    };
    let cells = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let two = cells.flat_map(|(i, j)| {
        let [a, b, c, d] = [point(i, j), point(i, j + 1), point(i + 1, j + 1), point(i + 1, j)];
        [[a, b, c], [a, c, d]]
    });
    two.collect()
}
