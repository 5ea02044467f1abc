//! Distributes tiles over threads: adaptive blocks, progress, stopping and continuing.

mod budget;
mod clock;
mod plan;
mod sections;
mod tile;

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard};

use rayon::prelude::*;

use crate::frame::FrameScene;
pub use crate::integrator::Statistics;
pub use budget::{Budget, render_until};
pub use plan::{Part, Plan};
use sections::Sections;
use slo_picture::film::{Area, Film, Steps, TILE};
use tile::TileRenderer;

/// Watches a rendering and may stop it. Called from many threads.
pub trait Observer: Sync {
    /// Reports a further share of the picture that is done; the whole picture is 1.
    fn advanced(&self, share: f64);
    /// Reports a share of the picture that was done by an earlier run. Counts as advanced by
    /// default.
    fn resumed(&self, share: f64) {
        self.advanced(share);
    }
    /// Whether to stop after the current step of each tile.
    fn should_stop(&self) -> bool {
        false
    }
    /// Whether to stop at once and lose the current step. If rays branch without end, a step may
    /// take hours.
    fn gives_up(&self) -> bool {
        false
    }
    /// Whether to call [`keep`](Self::keep) now.
    fn wants_film(&self) -> bool {
        false
    }
    /// Receives a copy of the film at this moment, and the steps that it must at least be continued
    /// to if it is exposed step by step. The film is `None` if there is no memory for a copy.
    fn keep(&self, film: Option<Film>, steps: Steps) {
        drop((film, steps));
    }
}

/// An exposed film, and what was traced for it.
#[derive(Clone, Debug)]
pub struct Exposed {
    /// The film, including the samples that it had before.
    pub film: Film,
    /// Counts of this run.
    pub statistics: Statistics,
    /// Whether the film has all samples of the plan; false if the observer stopped the rendering.
    pub is_complete: bool,
}

/// Exposes a film as the plan asks, on the threads of the current rayon pool. It continues from the
/// samples in `film`, which must come from the same frame and from a plan that this plan continues.
pub fn render(frame: &FrameScene, plan: &Plan, film: Film, observer: &dyn Observer) -> Exposed {
    let area = film.area();
    let run = Run::new(frame, film, observer);
    // One set of working memory for each thread. A tile never waits for another one on its thread.
    let memory: Vec<_> =
        (0..rayon::current_num_threads()).map(|_| Mutex::new(TileRenderer::default())).collect();
    let (width, height) = (frame.camera.width(), frame.camera.height());
    let expose = |tile: Area| {
        let thread = rayon::current_thread_index().unwrap_or(0);
        run.expose(&mut lock(&memory[thread]), tile, &plan.at(tile, width, height))
    };
    // Threads take sections. When none is left, they steal tiles from the sections of others.
    let stopped = Sections::new(&frame.settings, width, height)
        .areas()
        .into_par_iter()
        .with_max_len(frame.settings.sections_per_thread.max(1) as usize)
        .try_for_each(|section| {
            let tiles: Vec<_> = section.cells(TILE).filter(|&t| plan.includes(t, width)).collect();
            let tiles = tiles.into_par_iter().map(|tile| tile.common(&area)).with_max_len(1);
            tiles.filter(|tile| !tile.is_empty()).try_for_each(expose)
        });
    run.exposed(stopped.is_ok())
}

/// The observer asked to stop.
struct Stopped;

/// What all threads share.
struct Run<'a> {
    frame: &'a FrameScene,
    /// Number of pixels in the film's area.
    pixels: f64,
    result: Mutex<(Film, Statistics)>,
    observer: &'a dyn Observer,
    /// The furthest step that was begun, with `done` in the upper half; 0 if the picture is not
    /// exposed in steps.
    steps: AtomicU64,
}

impl<'a> Run<'a> {
    fn new(frame: &'a FrameScene, film: Film, observer: &'a dyn Observer) -> Self {
        let pixels = film.area().len() as f64;
        let result = Mutex::new((film, Statistics::default()));
        Self { frame, pixels, result, observer, steps: AtomicU64::new(0) }
    }

    /// Notes that a tile is about to take a step.
    fn note_step(&self, steps: Steps) {
        let packed = (u64::from(steps.done) << 32) | u64::from(steps.tiles);
        self.steps.fetch_max(packed, Ordering::SeqCst);
    }

    fn exposed(self, is_complete: bool) -> Exposed {
        let (film, statistics) = self.result.into_inner().unwrap_or_else(|p| p.into_inner());
        Exposed { film, statistics, is_complete }
    }

    /// Exposes one tile as a plan asks. The film receives the samples of each step, so that at most
    /// one step is lost.
    fn expose(&self, renderer: &mut TileRenderer, tile: Area, plan: &Plan) -> Result<(), Stopped> {
        let share = tile.len() as f64 / self.pixels;
        let before = renderer.begin(self.frame.isa, &lock(&self.result).0, tile, plan);
        let mut shown = before * share;
        if before > 0.0 {
            self.resumed(shown);
        }
        while renderer.plan_step(self.frame.isa, plan) {
            if self.observer.should_stop() {
                return Err(Stopped);
            }
            let step = renderer.take_step(self.frame, plan, &|| self.observer.gives_up());
            let (film, statistics, samples) = step.ok_or(Stopped)?;
            {
                let mut result = lock(&self.result);
                result.0.put(film);
                result.1 += statistics;
            }
            if let Some(all) = plan.uniform() {
                let step = samples as f64 / f64::from(all.max(1)) / self.pixels;
                shown += step;
                self.advanced(step);
            }
            self.show_film();
        }
        self.advanced(share - shown);
        Ok(())
    }

    /// Reports progress, except for a picture in steps: their number is unknown, so the clock
    /// reports it.
    fn advanced(&self, share: f64) {
        if self.steps.load(Ordering::SeqCst) == 0 {
            self.observer.advanced(share);
        }
    }

    fn resumed(&self, share: f64) {
        if self.steps.load(Ordering::SeqCst) == 0 {
            self.observer.resumed(share);
        }
    }

    /// Gives the observer a copy of the film if it wants one. Other threads continue meanwhile.
    fn show_film(&self) {
        if self.observer.wants_film() {
            let film = lock(&self.result).0.try_clone();
            let packed = self.steps.load(Ordering::SeqCst);
            let steps = Steps { done: (packed >> 32) as u32, tiles: packed as u32 };
            self.observer.keep(film, steps);
        }
    }
}

/// Locks a mutex, even if a thread has panicked. Sums are consistent at every moment, so a panic
/// leaves nothing broken behind a lock.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}
