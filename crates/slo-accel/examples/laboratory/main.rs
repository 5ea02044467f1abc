//! Counts what structures cost in the scenes of Haines' Standard Procedural Databases, or in any other NFF file.
//!
//! ```text
//! cargo run --release -p slo-accel --example laboratory -- balls.nff GRID:cells=46x46x3 OCTREE:depth=6
//! ```
//!
//! Every sphere, cone and polygon of the file is one object. For each structure the same rays are traced, as Haines
//! prescribes: 513 x 513 from the eye, one to each light in front of a hit, and all reflected and refracted ones to depth
//! 5. Prints JSON: numbers of rays by kind, what structures consist of, and sums and maxima of what was counted, by kind
//! of ray. Times are those of the processor, of all threads together. `scripts/reproduce/structures.py` compares them with published ones.

mod nff;
mod objects;
mod rays;

use std::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use rayon::prelude::*;
use slo_accel::glam::DVec3;
use slo_accel::math::Bounds;
use slo_accel::study::{Any, Counts, Kind, Parameters, Statistics, Totals};

use crate::nff::{Scene, View};
use crate::rays::{Counted, Plan, Structure, Tracer};

#[derive(Parser)]
#[command(about = "Counts what structures cost in an NFF scene.")]
struct Arguments {
    /// The scene.
    file: PathBuf,
    /// Structures, such as GRID:cells=46x46x3,mailbox=1, OCTREE:depth=6 or NAIVE
    #[arg(required = true)]
    structures: Vec<String>,
    /// Rays in a row, and rows.
    #[arg(long, default_value_t = 513)]
    size: u32,
    /// Only every so many rays of a row, and rows.
    #[arg(long, default_value_t = 1)]
    every: u32,
    /// Rays on the way from the eye to the last hit.
    #[arg(long, default_value_t = 5)]
    depth: u32,
    /// Rays to lights go on to the nearest hit, and do not end at the first.
    #[arg(long)]
    nearest_shadows: bool,
    /// Frames of an orbit of the eye about the point that it looks at.
    #[arg(long, default_value_t = 1)]
    orbit: u32,
    /// The lights go around that point instead, about the same axis.
    #[arg(long)]
    orbit_lights: bool,
    /// Threads.
    #[arg(long, default_value_t = 1)]
    threads: usize,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(json) => {
            println!("{json}");
            ExitCode::SUCCESS
        }
        Err(message) => {
            eprintln!("laboratory: {message}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<String, String> {
    let text = std::fs::read_to_string(&arguments.file)
        .map_err(|error| format!("{}: {error}", arguments.file.display()))?;
    let scene = nff::read(&text)?;
    let plan = Plan {
        size: arguments.size.max(2),
        every: arguments.every.max(1),
        depth: arguments.depth,
        nearest_shadows: arguments.nearest_shadows,
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(arguments.threads);
    let pool = pool.build().map_err(|error| error.to_string())?;
    let found = arguments.structures.iter().map(|name| {
        let structure = structure(name)?;
        Ok(format!(
            "    {{\"name\": \"{name}\", {}}}",
            measure(&scene, structure, plan, arguments, &pool)
        ))
    });
    let found = found.collect::<Result<Vec<_>, String>>()?.join(",\n");
    let (objects, lights) = (scene.objects.len(), scene.lights.len());
    Ok(format!("{{\"objects\": {objects}, \"lights\": {lights}, \"structures\": [\n{found}\n]}}"))
}

/// Reads a structure and its parameters; nothing for `NAIVE`.
fn structure(text: &str) -> Result<Option<(Kind, Parameters)>, String> {
    let (name, rest) = text.split_once(':').unwrap_or((text, ""));
    if name == "NAIVE" {
        return Ok(None);
    }
    let known = Kind::NAMES.iter().find(|(known, _)| *known == name);
    let &(_, kind) = known.ok_or_else(|| {
        let names: Vec<&str> = Kind::NAMES.iter().map(|(name, _)| *name).collect();
        format!("`{name}` is no structure: {}", names.join(", "))
    })?;
    Ok(Some((kind, rest.parse::<Parameters>()?)))
}

/// Builds a structure and traces the rays. Returns members of a JSON object.
fn measure(
    scene: &Scene,
    structure: Option<(Kind, Parameters)>,
    plan: Plan,
    arguments: &Arguments,
    pool: &rayon::ThreadPool,
) -> String {
    let boxes: Vec<Bounds> = scene.objects.iter().map(|object| object.shape.bounds()).collect();
    let all = boxes.iter().copied().reduce(Bounds::union);
    let diagonal = all.map_or(0.0, |all| all.size().as_dvec3().length());
    let begin = seconds_worked();
    let structure = match structure {
        Some((kind, parameters)) => Structure::Study(Any::new(kind, &boxes, &parameters)),
        None => Structure::Naive(boxes.len() as u32),
    };
    let build = seconds_worked() - begin;

    let begin = seconds_worked();
    let (mut counted, mut path) = (Counted::default(), vec![]);
    let frames = arguments.orbit.max(1);
    for frame in 0..frames {
        let angle = std::f64::consts::TAU * f64::from(frame) / f64::from(frames);
        let (mut view, mut lights) = (scene.view, scene.lights.clone());
        if arguments.orbit_lights {
            lights.iter_mut().for_each(|light| *light = turned(&scene.view, *light, angle));
        } else {
            view.eye = turned(&scene.view, view.eye, angle);
        }
        let tracer = Tracer::new(scene, &lights, &structure, plan, diagonal);
        let start = seconds_worked();
        let rows: Vec<Counted> = pool
            .install(|| tracer.rows().into_par_iter().map(|row| tracer.row(&view, row)).collect());
        let mut of_frame = Counted::default();
        rows.into_iter().for_each(|row| of_frame.add(row));
        path.push(frame_of(&of_frame, seconds_worked() - start));
        counted.add(of_frame);
    }
    let trace = seconds_worked() - begin;

    let of = match &structure {
        Structure::Study(study) => study.statistics(),
        Structure::Naive(_) => Statistics::default(),
    };
    let cells = of.cells.map_or("null".into(), |[x, y, z]| format!("[{x}, {y}, {z}]"));
    let mut json = format!(
        "\"build_s\": {build:.6}, \"trace_s\": {trace:.6}, \"cells\": {cells}, \"interior\": {}, \"leaves\": {}, \
         \"empty_leaves\": {}, \"references\": {}, \"deepest\": {}, \"largest_leaf\": {}, \"bytes\": {}, \
         \"bytes_of_building\": {}, \"sah\": {:.4}",
        of.interior,
        of.leaves,
        of.empty_leaves,
        of.references,
        of.deepest,
        of.largest_leaf,
        of.bytes,
        of.bytes_of_building,
        of.sah,
    );
    let Counted { primary, shadow, secondary } = counted;
    for (name, totals) in [("primary", primary), ("shadow", shadow), ("secondary", secondary)] {
        let _ = write!(json, ",\n     \"{name}\": {}", totals_of(&totals));
    }
    if frames > 1 {
        let _ = write!(json, ",\n     \"path\": [\n      {}]", path.join(",\n      "));
    }
    json
}

/// What a frame of an orbit takes: seconds, and rays, steps and tests by kind.
fn frame_of(Counted { primary, shadow, secondary }: &Counted, seconds: f64) -> String {
    let kinds = [("primary", primary), ("shadow", shadow), ("secondary", secondary)];
    let kinds = kinds.map(|(name, Totals { rays, sum, .. })| {
        format!("\"{name}\": [{rays}, {}, {}]", sum.steps, sum.tests)
    });
    format!("{{\"trace_s\": {seconds:.6}, {}}}", kinds.join(", "))
}

fn totals_of(totals: &Totals) -> String {
    let members = |counts: &Counts| {
        let pairs = Counts::NAMES.iter().zip(counts.numbers());
        pairs.map(|(name, number)| format!("\"{name}\": {number}")).collect::<Vec<_>>().join(", ")
    };
    format!(
        "{{\"rays\": {}, \"hits\": {}, \"lcv\": {:.4}, {}, \"highest\": {{{}}}}}",
        totals.rays,
        totals.hits,
        totals.leaf_count_variability(),
        members(&totals.sum),
        members(&totals.highest),
    )
}

/// Where a point is after it has gone around the point that a view looks at, by an angle.
fn turned(view: &View, point: DVec3, angle: f64) -> DVec3 {
    let axis = view.up.normalize();
    let from = point - view.target;
    let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
    let along: DVec3 = axis * axis.dot(from);
    view.target + along + (from - along) * cosine + axis.cross(from) * sine
}

/// Seconds that processors have worked for this program.
#[cfg(target_os = "linux")]
fn seconds_worked() -> f64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    now.tv_sec as f64 + 1e-9 * now.tv_nsec as f64
}

/// Seconds since the first call: other systems have other clocks.
#[cfg(not(target_os = "linux"))]
fn seconds_worked() -> f64 {
    static START: std::sync::LazyLock<std::time::Instant> =
        std::sync::LazyLock::new(std::time::Instant::now);
    START.elapsed().as_secs_f64()
}
