//! Tiles over threads, adaptive blocks, progress, stopping and going on.

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

/// Who watches a rendering and may stop it; called from many threads.
pub trait Observer: Sync {
    /// So much more of the picture is done; all of it is 1.
    fn advanced(&self, share: f64);
    /// So much of the picture was done before; counts as advanced.
    fn resumed(&self, share: f64) {
        self.advanced(share);
    }
    /// Whether to stop soon.
    fn should_stop(&self) -> bool {
        false
    }
    /// Whether to stop at once, and to lose the step that is under way: where rays branch without end,
    /// it may take hours.
    fn gives_up(&self) -> bool {
        false
    }
    /// Whether [`keep`](Self::keep) is to be called now.
    fn wants_film(&self) -> bool {
        false
    }
    /// All that is known of the picture at this moment, and how far it is at least to be taken from
    /// there, where it is exposed step by step. `None`: there is no memory for a copy.
    fn keep(&self, film: Option<Film>, steps: Steps) {
        drop((film, steps));
    }
}

/// A film, and what was traced for it.
#[derive(Clone, Debug)]
pub struct Exposed {
    /// With the samples that it had before.
    pub film: Film,
    /// Of this run.
    pub statistics: Statistics,
    /// Whether all samples of the plan are there; false where the observer asked to stop.
    pub is_complete: bool,
}

/// Exposes a film to what the plan asks for, on the threads of the current rayon pool. It goes on
/// from what `film` knows: that has to come from the same frame, and from a plan that would have
/// gone on to this one.
pub fn render(frame: &FrameScene, plan: &Plan, film: Film, observer: &dyn Observer) -> Exposed {
    let area = film.area();
    let run = Run::new(frame, film, observer);
    // One set of working memory per thread; a tile never waits for another inside its thread.
    let memory: Vec<_> =
        (0..rayon::current_num_threads()).map(|_| Mutex::new(TileRenderer::default())).collect();
    let (width, height) = (frame.camera.width(), frame.camera.height());
    let expose = |tile: Area| {
        let thread = rayon::current_thread_index().unwrap_or(0);
        run.expose(&mut lock(&memory[thread]), tile, &plan.at(tile, width, height))
    };
    // Threads take sections, and when none is left steal tiles of others' sections.
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

/// What all threads look at.
struct Run<'a> {
    frame: &'a FrameScene,
    /// In the film's area.
    pixels: f64,
    result: Mutex<(Film, Statistics)>,
    observer: &'a dyn Observer,
    /// The furthest step that was begun, `done` in the upper half; 0 where there are no steps.
    steps: AtomicU64,
}

impl<'a> Run<'a> {
    fn new(frame: &'a FrameScene, film: Film, observer: &'a dyn Observer) -> Self {
        let pixels = film.area().len() as f64;
        let result = Mutex::new((film, Statistics::default()));
        Self { frame, pixels, result, observer, steps: AtomicU64::new(0) }
    }

    /// A tile is about to be taken to a step.
    fn note_step(&self, steps: Steps) {
        let packed = (u64::from(steps.done) << 32) | u64::from(steps.tiles);
        self.steps.fetch_max(packed, Ordering::SeqCst);
    }

    fn exposed(self, is_complete: bool) -> Exposed {
        let (film, statistics) = self.result.into_inner().unwrap_or_else(|p| p.into_inner());
        Exposed { film, statistics, is_complete }
    }

    /// Exposes one tile to a plan: what is known after a while is never lost.
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

    /// Of steps, whose number is not known, the clock tells the progress.
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

    /// Gives the observer a copy of the film where it wants one: the others go on meanwhile.
    fn show_film(&self) {
        if self.observer.wants_film() {
            let film = lock(&self.result).0.try_clone();
            let packed = self.steps.load(Ordering::SeqCst);
            let steps = Steps { done: (packed >> 32) as u32, tiles: packed as u32 };
            self.observer.keep(film, steps);
        }
    }
}

/// Sums are whole at every moment, so a panic elsewhere leaves nothing broken behind a lock.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}
