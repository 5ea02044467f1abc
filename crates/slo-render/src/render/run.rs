//! One rendering, as all threads see it.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use slo_picture::film::{Area, Film, Steps};

use super::lock::lock;
use super::observer::{Exposed, Observer};
use super::plan::Plan;
use super::tile::TileRenderer;
use crate::frame::FrameScene;
use crate::integrator::Statistics;

/// The observer asked to stop.
pub(super) struct Stopped;

/// What all threads look at.
pub(super) struct Run<'a> {
    pub(super) frame: &'a FrameScene,
    /// In the film's area.
    pub(super) pixels: f64,
    pub(super) result: Mutex<(Film, Statistics)>,
    pub(super) observer: &'a dyn Observer,
    /// The furthest step that was begun, `done` in the upper half; 0 where there are no steps.
    pub(super) steps: AtomicU64,
}

impl<'a> Run<'a> {
    pub(super) fn new(frame: &'a FrameScene, film: Film, observer: &'a dyn Observer) -> Self {
        let pixels = film.area().len() as f64;
        let result = Mutex::new((film, Statistics::default()));
        Self { frame, pixels, result, observer, steps: AtomicU64::new(0) }
    }

    /// A tile is about to be taken to a step.
    pub(super) fn note_step(&self, steps: Steps) {
        let packed = (u64::from(steps.done) << 32) | u64::from(steps.tiles);
        self.steps.fetch_max(packed, Ordering::SeqCst);
    }

    pub(super) fn exposed(self, is_complete: bool) -> Exposed {
        let (film, statistics) = self.result.into_inner().unwrap_or_else(|p| p.into_inner());
        Exposed { film, statistics, is_complete }
    }

    /// Exposes one tile to a plan: what is known after a while is never lost.
    pub(super) fn expose(
        &self,
        renderer: &mut TileRenderer,
        tile: Area,
        plan: &Plan,
    ) -> Result<(), Stopped> {
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
    pub(super) fn advanced(&self, share: f64) {
        if self.steps.load(Ordering::SeqCst) == 0 {
            self.observer.advanced(share);
        }
    }

    pub(super) fn resumed(&self, share: f64) {
        if self.steps.load(Ordering::SeqCst) == 0 {
            self.observer.resumed(share);
        }
    }

    /// Gives the observer a copy of the film where it wants one: the others go on meanwhile.
    pub(super) fn show_film(&self) {
        if self.observer.wants_film() {
            let film = lock(&self.result).0.try_clone();
            let packed = self.steps.load(Ordering::SeqCst);
            let steps = Steps { done: (packed >> 32) as u32, tiles: packed as u32 };
            self.observer.keep(film, steps);
        }
    }
}
