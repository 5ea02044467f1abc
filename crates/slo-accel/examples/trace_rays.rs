//! Traces sets of rays through a mesh and compares the hits with stored ones: the measuring tool
//! behind `docs/performance.md`.
//!
//! ```text
//! trace_rays MESH.tri RAYS.rays [--accelerator BVH|KDTREE|CWBVH|NONE] [--spatial-splits]
//!            [--isa auto|avx512|avx2|neon|portable] [--threads N] [--repeat N] [--shapes MESH2.tri]
//!            [--copies FILE]
//! ```
//!
//! Both files are little-endian. A mesh is the number of triangles (u32), then nine f32 for each.
//! Rays are the number of sets (u32); a set is its number of rays n, its kind (0 closest hit, 1 any
//! hit), n rays of eight f32 (origin, direction, end, time), and n hits of an f32 and a u32
//! (distance, triangle): no hit where the distance is above 1e29; for any hit, 1 where blocked. The
//! first three sets are taken for rays whose neighbours are alike: camera, lens, and shadow rays.
//!
//! With a second shape, the triangles of the mesh move to it while the time goes from 0 to 1, and each
//! ray meets them at its own time.
//!
//! Copies place the mesh: a u32 n, then n times twelve f32, the rows of object to world.
//!
//! `mrays_per_s` counts the time that passes, `cpu_mrays_per_s` the time that the processor works, of
//! all threads.
//!
//! Prints a line of JSON for the structure, one for copies, and one for each set.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use clap::Parser;
use glam::{Mat3, Vec3};
use slo_accel::instances::{Affine, Child, Placements};
use slo_accel::{
    Accelerator, Bending, BuildOptions, Coherence, Hits, Instances, InstancesScratch, Isa, NO_HIT,
    Rays, Scratch, Structure, Triangle,
};

/// Rays that one call answers.
const BATCH: usize = 1024;

/// Sets of rays whose neighbours are alike.
const COHERENT_SETS: usize = 3;

/// Distances that differ by more, relative to distances above 1, disagree.
const TOLERANCE: f32 = 1e-3;

#[derive(Parser)]
struct Options {
    /// The mesh
    mesh: PathBuf,
    /// The rays and the hits to compare with
    rays: PathBuf,
    /// The structure that is built: BVH, KDTREE, CWBVH, or NONE
    #[arg(long, default_value = "BVH")]
    accelerator: String,
    /// Cut triangles where boxes of the BVH would overlap
    #[arg(long)]
    spatial_splits: bool,
    /// The instruction set: auto, avx512, avx2, neon, or portable
    #[arg(long, default_value = "auto")]
    isa: String,
    /// Threads that build and trace
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// How often each set is traced; the best counts
    #[arg(long, default_value_t = 5)]
    repeat: usize,
    /// The shape to which the triangles of the mesh move
    #[arg(long, conflicts_with = "copies")]
    shapes: Option<PathBuf>,
    /// Where copies of the mesh are
    #[arg(long)]
    copies: Option<PathBuf>,
}

/// What rays are traced through.
enum Scene {
    Mesh(Structure),
    Bending(Bending),
    Copies(Instances),
}

/// Rays that one call answers, each with its time.
struct Batch {
    rays: Rays,
    times: Vec<f32>,
}

/// Rays of one kind, in batches, and the hits that they should have.
struct RaySet {
    any_hit: bool,
    batches: Vec<Batch>,
    stored: Vec<f32>,
}

/// Numbers of a file, in order.
struct Numbers<'a>(&'a [u8]);

impl Numbers<'_> {
    fn u32(&mut self) -> Result<u32, String> {
        let (number, rest) = self.0.split_first_chunk().ok_or("the file ends too early")?;
        self.0 = rest;
        Ok(u32::from_le_bytes(*number))
    }

    fn f32(&mut self) -> Result<f32, String> {
        self.u32().map(f32::from_bits)
    }

    fn vector(&mut self) -> Result<Vec3, String> {
        Ok(Vec3::new(self.f32()?, self.f32()?, self.f32()?))
    }
}

fn read(path: &Path) -> Result<Vec<u8>, String> {
    std::fs::read(path).map_err(|e| format!("{}: {e}", path.display()))
}

fn read_triangles(path: &Path) -> Result<Vec<Triangle>, String> {
    let bytes = read(path)?;
    let mut numbers = Numbers(&bytes);
    let parse = |numbers: &mut Numbers| {
        let count = numbers.u32()?;
        (0..count)
            .map(|_| Ok([numbers.vector()?, numbers.vector()?, numbers.vector()?]))
            .collect::<Result<_, String>>()
    };
    parse(&mut numbers).map_err(|e| format!("{}: {e}", path.display()))
}

fn read_copies(path: &Path) -> Result<Placements, String> {
    let bytes = read(path)?;
    let mut numbers = Numbers(&bytes);
    let parse = |numbers: &mut Numbers| {
        let count = numbers.u32()? as usize;
        let mut placements = Placements::with_capacity(count);
        for _ in 0..count {
            let mut row = || Ok::<_, String>((numbers.vector()?, numbers.f32()?));
            let rows = [row()?, row()?, row()?];
            let matrix = Mat3::from_cols(rows[0].0, rows[1].0, rows[2].0).transpose();
            let translation = Vec3::from_array(rows.map(|(_, last)| last));
            placements.push(0, &[Affine { matrix, translation }]);
        }
        Ok(placements)
    };
    parse(&mut numbers).map_err(|e: String| format!("{}: {e}", path.display()))
}

fn read_rays(path: &Path) -> Result<Vec<RaySet>, String> {
    let bytes = read(path)?;
    let mut numbers = Numbers(&bytes);
    let count = numbers.u32()?;
    (0..count)
        .map(|_| read_set(&mut numbers))
        .collect::<Result<_, _>>()
        .map_err(|e: String| format!("{}: {e}", path.display()))
}

fn read_set(numbers: &mut Numbers) -> Result<RaySet, String> {
    let (count, kind) = (numbers.u32()? as usize, numbers.u32()?);
    if kind > 1 {
        return Err(format!("a set of kind {kind}, expected 0 or 1"));
    }
    let mut batches = Vec::new();
    for i in 0..count {
        if i % BATCH == 0 {
            batches.push(Batch { rays: Rays::with_capacity(BATCH.min(count - i)), times: vec![] });
        }
        let (origin, direction) = (numbers.vector()?, numbers.vector()?);
        let (t_max, time) = (numbers.f32()?, numbers.f32()?);
        let batch = batches.last_mut().ok_or("no batch")?;
        batch.rays.push(origin, direction, t_max);
        batch.times.push(time);
    }
    let mut stored = Vec::new();
    for _ in 0..count {
        stored.push(numbers.f32()?);
        numbers.u32()?;
    }
    Ok(RaySet { any_hit: kind == 1, batches, stored })
}

/// Answers of one thread.
#[derive(Default)]
struct Answers {
    hits: Hits,
    instance: Vec<u32>,
    blocked: Vec<bool>,
    scratch: Scratch,
    instances_scratch: InstancesScratch,
}

impl Answers {
    fn ask(&mut self, scene: &Scene, batch: &Batch, any_hit: bool, coherence: Coherence) {
        let Self { hits, instance, blocked, scratch, instances_scratch } = self;
        let Batch { rays, times } = batch;
        match (scene, any_hit) {
            (Scene::Mesh(structure), true) => {
                structure.occluded(rays, coherence, blocked, scratch);
            }
            (Scene::Mesh(structure), false) => {
                structure.intersect(rays, coherence, hits, scratch);
            }
            (Scene::Bending(bending), true) => {
                bending.occluded(rays, times, coherence, blocked, scratch);
            }
            (Scene::Bending(bending), false) => {
                bending.intersect(rays, times, coherence, hits, scratch);
            }
            (Scene::Copies(copies), true) => {
                copies.occluded(rays, times, coherence, blocked, instances_scratch);
            }
            (Scene::Copies(copies), false) => {
                copies.intersect(rays, times, coherence, hits, instance, instances_scratch);
            }
        }
    }

    /// How many answers differ from stored ones.
    fn disagreements(&self, any_hit: bool, stored: &[f32]) -> usize {
        let differs = |(i, &stored): (usize, &f32)| {
            if any_hit {
                self.blocked[i] != (stored == 1.0)
            } else {
                let is_hit = self.hits.primitive[i] != NO_HIT;
                let error = (self.hits.t[i] - stored).abs();
                is_hit != (stored < 1e29) || (is_hit && error > TOLERANCE * stored.max(1.0))
            }
        };
        stored.iter().enumerate().filter(|&pair| differs(pair)).count()
    }
}

/// Seconds that the threads take for a set, and seconds that processors work for it: each thread
/// takes the next batch as soon as it is free.
fn trace(scene: &Scene, set: &RaySet, coherence: Coherence, threads: usize) -> [f64; 2] {
    let (next, ready) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let work = || {
        let mut answers = Answers::default();
        // Memory is touched, and threads are awake, before the clock starts.
        if let Some(batch) = set.batches.first() {
            answers.ask(scene, batch, set.any_hit, coherence);
        }
        ready.fetch_add(1, Ordering::SeqCst);
        while ready.load(Ordering::SeqCst) < threads {
            std::hint::spin_loop();
        }
        let (start, worked) = (Instant::now(), seconds_worked());
        while let Some(batch) = set.batches.get(next.fetch_add(1, Ordering::Relaxed)) {
            answers.ask(scene, batch, set.any_hit, coherence);
        }
        (start, Instant::now(), seconds_worked() - worked)
    };
    std::thread::scope(|scope| {
        let others: Vec<_> = (1..threads).map(|_| scope.spawn(work)).collect();
        let mine = work();
        let spans = others.into_iter().map(|other| other.join().expect("no thread panics"));
        let (start, end, worked) = spans
            .fold(mine, |(start, end, worked), (s, e, w)| (start.min(s), end.max(e), worked + w));
        [(end - start).as_secs_f64(), worked]
    })
}

/// Seconds that a processor has worked for this thread.
#[cfg(target_os = "linux")]
fn seconds_worked() -> f64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    now.tv_sec as f64 + 1e-9 * now.tv_nsec as f64
}

/// Seconds since the first call: other systems have other clocks.
#[cfg(not(target_os = "linux"))]
fn seconds_worked() -> f64 {
    static START: std::sync::LazyLock<Instant> = std::sync::LazyLock::new(Instant::now);
    START.elapsed().as_secs_f64()
}

fn run(options: &Options) -> Result<(), String> {
    let accelerator = Accelerator::by_name(&options.accelerator)?;
    let isa = Isa::by_name(&options.isa)?;
    let how = BuildOptions::new(isa).with_spatial_splits(options.spatial_splits);
    let threads = options.threads.max(1);
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build_global()
        .map_err(|e| e.to_string())?;
    let triangles = read_triangles(&options.mesh)?;
    let sets = read_rays(&options.rays)?;
    let count = triangles.len();
    let end = options.shapes.as_deref().map(read_triangles).transpose()?;
    if end.as_ref().is_some_and(|end| end.len() != count) {
        return Err("the second shape has another number of triangles".to_owned());
    }
    let start = Instant::now();
    let (mesh, bytes) = match end {
        None => {
            let structure = Structure::build(accelerator, triangles, how);
            let bytes = structure.memory();
            (Scene::Mesh(structure), bytes)
        }
        Some(end) => {
            let bending = Bending::build(&[triangles, end], &[0.0, 1.0], isa);
            let bytes = bending.memory();
            (Scene::Bending(bending), bytes)
        }
    };
    let build = start.elapsed().as_secs_f64();
    let bytes = bytes as f64 / count.max(1) as f64;
    print(&format!(r#"{{"build_s":{build:.4},"bytes_per_triangle":{bytes:.1}}}"#))?;
    let scene = match (&options.copies, mesh) {
        (Some(path), Scene::Mesh(structure)) => {
            let placements = read_copies(path)?;
            let count = placements.len();
            let start = Instant::now();
            let child = Child::Structure(Arc::new(structure));
            let copies =
                Instances::build(vec![child], placements, isa).map_err(|e| e.to_string())?;
            let build = start.elapsed().as_secs_f64();
            let bytes = copies.memory() as f64 / count.max(1) as f64;
            print(&format!(r#"{{"copies_build_s":{build:.4},"bytes_per_copy":{bytes:.1}}}"#))?;
            Scene::Copies(copies)
        }
        (_, mesh) => mesh,
    };
    for (i, set) in sets.iter().enumerate() {
        let coherence = if i < COHERENT_SETS { Coherence::Coherent } else { Coherence::Incoherent };
        let rays = set.stored.len();
        let mut answers = Answers::default();
        let disagreements: usize = set
            .batches
            .iter()
            .zip(set.stored.chunks(BATCH))
            .map(|(batch, stored)| {
                answers.ask(&scene, batch, set.any_hit, coherence);
                answers.disagreements(set.any_hit, stored)
            })
            .sum();
        let best = (0..options.repeat.max(1))
            .map(|_| trace(&scene, set, coherence, threads))
            .fold([f64::INFINITY; 2], |best, one| [best[0].min(one[0]), best[1].min(one[1])]);
        let [speed, of_cpu] = best.map(|seconds| rays as f64 / seconds / 1e6);
        let share = disagreements as f64 / rays.max(1) as f64;
        print(&format!(
            r#"{{"set":{i},"rays":{rays},"mrays_per_s":{speed:.3},"cpu_mrays_per_s":{of_cpu:.3},"disagreement":{share:.3e}}}"#
        ))?;
    }
    Ok(())
}

/// Prints a line; whoever reads may have gone.
fn print(line: &str) -> Result<(), String> {
    writeln!(std::io::stdout(), "{line}").map_err(|error| format!("can't print: {error}"))
}

fn main() -> ExitCode {
    match run(&Options::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}
