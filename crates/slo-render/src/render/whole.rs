//! All tiles of a picture over all threads.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Instant;

use rayon::prelude::*;
use slo_picture::film::{Area, Film, TILE};
use slo_scene::Integrator;

use super::lock::lock;
use super::observer::{Exposed, Observer};
use super::photon_map::photon_light;
use super::photons::Stretches;
use super::plan::Plan;
use super::run::{Run, Stopped};
use super::sections::Sections;
use super::tile::TileRenderer;
use crate::frame::FrameScene;

/// Exposes a film as the plan asks, on the threads of the current rayon pool. It continues from the
/// samples in `film`, which must come from the same frame and from a plan that this plan continues.
pub fn render(frame: &FrameScene, plan: &Plan, film: Film, observer: &dyn Observer) -> Exposed {
    let area = film.area();
    let run = Run::new(frame, film, plan, observer);
    // One set of working memory for each thread. A tile never waits for another one on its thread.
    let memory: Vec<_> =
        (0..rayon::current_num_threads()).map(|_| Mutex::new(TileRenderer::default())).collect();
    let (width, height) = (frame.camera.width(), frame.camera.height());
    let sections = Sections::new(&frame.settings, width, height).areas(&area);
    let tiles_of = |section: &Area| section.cells(TILE).filter(|&tile| plan.includes(tile, width));
    let tiles = || sections.iter().flat_map(tiles_of).collect::<Vec<_>>();
    let has_photons = frame.emission.is_some();
    let first_open = || run.first_open(|tile| plan.at(tile, width, height), &tiles(), &memory);
    let is_photon_map = frame.settings.integrator == Integrator::PhotonMap;
    let asks = has_photons || frame.is_guided() || is_photon_map;
    let first = if asks { first_open() } else { None };
    // A picture that has all its samples needs no field.
    if first.is_some() && !run.learn(&|share| observer.advanced(share)) {
        return run.exposed(false);
    }
    let gives_up = || observer.gives_up() || observer.should_stop();
    let mut light = None;
    if is_photon_map && first.is_some() {
        let start = Instant::now();
        let Some(found) = photon_light(frame, &gives_up) else { return run.exposed(false) };
        run.add_photons(found.counts(), start, 1.0);
        light = Some(Arc::new(found));
    }
    let mut stretches = Stretches::new(frame, first.filter(|_| has_photons), light);
    let mut is_complete = false;
    while !is_complete {
        let start = Instant::now();
        let Some(stretch) = stretches.next(plan, &gives_up) else { break };
        if let Some(maps) = &stretch.maps {
            run.add_photons(maps.counts(), start, stretch.share);
        }
        let is_open = AtomicBool::new(false);
        let expose = |tile: Area| {
            let thread = rayon::current_thread_index().unwrap_or(0);
            let plan = plan.at(tile, width, height);
            let is_done = run.expose(&mut lock(&memory[thread]), tile, &plan, &stretch)?;
            is_open.fetch_or(!is_done, Ordering::Relaxed);
            Ok(())
        };
        // Threads take sections. When none is left, they steal tiles from the sections of others.
        let stopped: Result<(), Stopped> = sections
            .par_iter()
            .with_max_len(frame.settings.sections_per_thread.max(1) as usize)
            .try_for_each(|section| {
                let tiles: Vec<_> = tiles_of(section).collect();
                tiles.into_par_iter().with_max_len(1).try_for_each(expose)
            });
        if stopped.is_err() {
            break;
        }
        is_complete = !is_open.into_inner();
    }
    run.exposed(is_complete)
}
