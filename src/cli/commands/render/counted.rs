//! What the rays of a frame took in the structures, as a table.

use std::io::{self, Read, Write};
use std::path::Path;

use serde_json::{Map, Value, json};

use super::done::Times;
use crate::cli::base::{Exit, Problem};
use crate::cli::files::load;
use crate::cli::options::Job;
use slo_accel::study::{COST_OF_STEP, COST_OF_TEST, Counts, Statistics as Structure, Totals};
use slo_picture::film::{Area, Film};
use slo_picture::output::{check_writable, open_regular, write_atomically};
use slo_render::frame::{CountedStructure, FrameError, FrameScene};
use slo_render::integrator::RayKind;
use slo_render::render::Statistics;
use slo_scene::SceneDescription;

/// How a table begins, so that no other file is replaced.
const ABOUT: &str = "counts of slo-rt";

/// What the rays of a frame took.
pub(super) struct Counted {
    table: Value,
    /// Steps and tests by pixel, if a map shows them.
    costs: Vec<[u64; 2]>,
}

/// Makes a frame count its rays, if the job asks for it.
///
/// # Errors
/// The frame cannot be counted.
pub(super) fn begin(job: &Job, frame: &mut FrameScene) -> Result<(), Problem> {
    if !job.maps.counts_rays() {
        return Ok(());
    }
    frame.count(job.maps.cost.is_some()).map_err(|error| match error {
        FrameError::Uncounted { reason } => {
            let option = if job.maps.counts.is_some() { "--count" } else { "--cost-map" };
            Problem::new(Exit::Usage, format!("{option}: {reason}"))
        }
        other => load::no_frame(other),
    })
}

/// Checks whether a table can be written to a path.
///
/// # Errors
/// Another file exists; what the system says of the folder or the file.
pub(super) fn check_path(path: &Path) -> Result<(), Problem> {
    let problem = |why: String| {
        Problem::new(Exit::CantCreate, format!("can't create `{}`: {why}", path.display()))
    };
    check_writable(path).map_err(|error| problem(error.to_string()))?;
    let mut begin = String::new();
    match open_regular(path) {
        Ok(file) => {
            // What is not text is not a table either.
            let is_text = file.take(64).read_to_string(&mut begin).is_ok();
            match is_text && (begin.is_empty() || begin.contains(ABOUT)) {
                true => Ok(()),
                false => Err(problem("there is a file already that has no counts".into())),
            }
        }
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        Err(error) => Err(problem(error.to_string())),
    }
}

impl Counted {
    /// What was counted of a frame; `None` if nothing was.
    pub(super) fn of(
        job: &Job,
        scene: &SceneDescription,
        number: i64,
        frame: &FrameScene,
        statistics: &Statistics,
        times: &Times,
    ) -> Option<Self> {
        job.maps.counts_rays().then(|| {
            let kinds = RayKind::NAMES.iter().zip(&statistics.rays);
            let rays: Map<String, Value> =
                kinds.map(|((name, _), totals)| ((*name).to_owned(), ray(totals))).collect();
            let structures: Vec<Value> = frame.counted_structures().iter().map(structure).collect();
            let table = json!({
                "about": ABOUT,
                "accelerator": scene.settings.accelerator.name(),
                "accelerator_options": job.parameters().to_string(),
                "cost_of_step": COST_OF_STEP,
                "cost_of_test": COST_OF_TEST,
                "frame": number,
                "rays": rays,
                "seconds": {
                    "building": times.building.as_secs_f64(),
                    "photons": times.photons.as_secs_f64(),
                    "rendering_and_counting": times.rendering.as_secs_f64(),
                },
                "structures": structures,
            });
            Self { table, costs: frame.costs() }
        })
    }

    /// Writes the table.
    pub(super) fn write(&self, path: &Path) -> io::Result<()> {
        let text = serde_json::to_string_pretty(&self.table).map_err(io::Error::other)?;
        write_atomically(path, |file| writeln!(file, "{text}"))
    }

    /// Steps, tests and their weighted sum per sample, of the pixels of an area.
    pub(super) fn costs(&self, film: &Film, area: Area, whole: Area) -> Vec<[f32; 3]> {
        let places = (area.y0..area.y1).flat_map(|y| (area.x0..area.x1).map(move |x| (x, y)));
        let cost = |((x, y), samples): ((u32, u32), u32)| {
            let place = y as usize * whole.width() as usize + x as usize;
            let each = |count: u64| count as f64 / f64::from(samples.max(1));
            let [steps, tests] = self.costs.get(place).copied().unwrap_or_default().map(each);
            let sum = COST_OF_STEP * steps + COST_OF_TEST * tests;
            [steps, tests, sum].map(|x| x as f32)
        };
        places.zip(film.pixels_of(area).map(|pixel| pixel.samples)).map(cost).collect()
    }
}

fn ray(totals: &Totals) -> Value {
    let Totals { rays, hits, sum, highest, .. } = totals;
    json!({
        "rays": rays,
        "hits": hits,
        "sum": counts(sum),
        "highest": counts(highest),
        "lcv": totals.leaf_count_variability(),
    })
}

fn counts(counts: &Counts) -> Value {
    let numbers = Counts::NAMES.into_iter().zip(counts.numbers());
    numbers.map(|(name, number)| (name.to_owned(), json!(number))).collect::<Map<_, _>>().into()
}

fn structure(CountedStructure { primitives, memory, statistics, .. }: &CountedStructure) -> Value {
    let mut value = json!({ "primitives": primitives, "bytes_with_primitives": memory });
    if let (Some(of), Some(object)) = (statistics, value.as_object_mut()) {
        let Structure { interior, leaves, empty_leaves, references, .. } = of;
        let further = json!({
            "interior": interior,
            "leaves": leaves,
            "empty_leaves": empty_leaves,
            "references": references,
            "duplication": of.duplication(),
            "deepest": of.deepest,
            "mean_depth": of.mean_depth,
            "mean_depth_by_area": of.mean_depth_by_area,
            "mean_leaf": of.mean_leaf(),
            "largest_leaf": of.largest_leaf,
            "leaf_sizes": of.leaf_sizes,
            "cells": of.cells,
            "bytes": of.bytes,
            "bytes_of_building": of.bytes_of_building,
            "sah": of.sah,
            "epo": of.epo,
        });
        object.extend(further.as_object().cloned().unwrap_or_default());
    }
    value
}
