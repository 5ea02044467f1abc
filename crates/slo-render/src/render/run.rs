//! One rendering, as all threads see it.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use rayon::prelude::*;
use slo_picture::film::{Area, Film, Steps};

use super::guide;
use super::lock::lock;
use super::observer::{Exposed, Observer};
use super::photons::Stretch;
use super::plan::Plan;
use super::tile::TileRenderer;
use crate::frame::FrameScene;
use crate::integrator::Statistics;
use crate::photons::PhotonCounts;

/// The observer asked to stop.
pub(super) struct Stopped;

/// What all threads share.
pub(super) struct Run<'a> {
    pub(super) frame: &'a FrameScene,
    /// Number of pixels in the film's area.
    pub(super) pixels: f64,
    /// Share of the work that is the picture; the rest is the learning of a field.
    picture: f64,
    pub(super) result: Mutex<(Film, Statistics)>,
    pub(super) observer: &'a dyn Observer,
    /// The furthest step that was begun, with `done` in the upper half; 0 if the picture is not
    /// exposed in steps.
    pub(super) steps: AtomicU64,
}

/// Samples that a pixel is expected to take if the number is not known.
const USUAL_SAMPLES: u32 = 128;

/// Estimates which share of the work is the picture, if a field is learned for it first.
fn share_of_picture(frame: &FrameScene, plan: &Plan, pixels: f64) -> f64 {
    if !frame.is_guided() || frame.field().is_some() {
        return 1.0;
    }
    let samples = pixels * f64::from(plan.uniform().unwrap_or(USUAL_SAMPLES).max(1));
    samples / (samples + guide::paths(frame.camera.width(), frame.camera.height()))
}

impl<'a> Run<'a> {
    pub(super) fn new(
        frame: &'a FrameScene,
        film: Film,
        plan: &Plan,
        observer: &'a dyn Observer,
    ) -> Self {
        let pixels = film.area().len() as f64;
        let result = Mutex::new((film, Statistics::default()));
        let picture = share_of_picture(frame, plan, pixels);
        Self { frame, pixels, picture, result, observer, steps: AtomicU64::new(0) }
    }

    /// Notes that a tile is about to take a step.
    pub(super) fn note_step(&self, steps: Steps) {
        let packed = (u64::from(steps.done) << 32) | u64::from(steps.tiles);
        self.steps.fetch_max(packed, Ordering::SeqCst);
    }

    /// A copy of the film as it is; `None` if there is no memory for it.
    pub(super) fn film(&self) -> Option<Film> {
        lock(&self.result).0.try_clone()
    }

    /// Returns to an earlier copy of the film.
    pub(super) fn restore(&self, film: Film) {
        lock(&self.result).0 = film;
    }

    pub(super) fn exposed(self, is_complete: bool) -> Exposed {
        let (film, statistics) = self.result.into_inner().unwrap_or_else(|p| p.into_inner());
        Exposed { film, statistics, is_complete }
    }

    /// Exposes one tile as a plan asks, for a stretch of samples. The film receives the samples of each
    /// step, so that at most one step is lost. Returns whether the tile has all samples.
    pub(super) fn expose(
        &self,
        renderer: &mut TileRenderer,
        tile: Area,
        plan: &Plan,
        stretch: &Stretch,
    ) -> Result<bool, Stopped> {
        let share = tile.len() as f64 / self.pixels;
        let before = renderer.begin(self.frame.isa, &lock(&self.result).0, tile, plan, stretch);
        let mut shown = before * share;
        if before > 0.0 && stretch.is_first {
            self.resumed(shown);
        }
        while renderer.plan_step(self.frame.isa, plan) {
            if self.observer.should_stop() {
                return Err(Stopped);
            }
            let step = renderer.take_step(self.frame, plan, &|| self.observer.gives_up());
            let (film, statistics, samples) = step.ok_or(Stopped)?;
            self.observer.exposed(film);
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
        if renderer.is_done() {
            self.advanced(share - shown);
        }
        Ok(renderer.is_done())
    }

    /// Returns the number of the next sample of the pixel that has the fewest among those that need more;
    /// `None` if none does.
    pub(super) fn first_open(
        &self,
        plan: impl Fn(Area) -> Plan + Sync,
        tiles: &[Area],
        memory: &[Mutex<TileRenderer>],
    ) -> Option<u32> {
        let isa = self.frame.isa;
        let of = |tile: &Area| {
            let thread = rayon::current_thread_index().unwrap_or(0);
            let mut renderer = lock(&memory[thread]);
            let film = &lock(&self.result).0;
            let plan = plan(*tile);
            renderer.begin(isa, film, *tile, &plan, &Stretch::WHOLE);
            renderer.first_open(isa, &plan)
        };
        tiles.par_iter().filter_map(of).min()
    }

    /// Learns the field that guides rays, if the frame has one that is not known. Returns whether it is
    /// known now; false if the observer asked to stop.
    pub(super) fn learn(&self, advanced: &(dyn Fn(f64) + Sync)) -> bool {
        let all = guide::paths(self.frame.camera.width(), self.frame.camera.height());
        let traced = |paths: usize| advanced(paths as f64 / all * (1.0 - self.picture));
        let gives_up = || self.observer.gives_up() || self.observer.should_stop();
        let was_known = self.frame.field().is_some();
        let done = guide::learn(self.frame, &traced, &gives_up).is_some();
        if let Some(field) = self.frame.field().filter(|_| !was_known) {
            self.observer.learned(field);
        }
        done
    }

    /// Notes what photons took that the next `share` of the picture uses, since when they were traced.
    pub(super) fn add_photons(&self, counts: PhotonCounts, since: Instant, share: f64) {
        lock(&self.result).1.photons += counts;
        self.observer.prepared(since.elapsed(), share * self.picture);
    }

    /// Reports progress, except for a picture in steps: their number is unknown, so the clock
    /// reports it.
    pub(super) fn advanced(&self, share: f64) {
        if self.steps.load(Ordering::SeqCst) == 0 {
            self.observer.advanced(share * self.picture);
        }
    }

    pub(super) fn resumed(&self, share: f64) {
        if self.steps.load(Ordering::SeqCst) == 0 {
            self.observer.resumed(share * self.picture);
        }
    }

    /// Gives the observer a copy of the film if it wants one. Other threads continue meanwhile.
    pub(super) fn show_film(&self) {
        if self.observer.wants_film() {
            let film = lock(&self.result).0.try_clone();
            let packed = self.steps.load(Ordering::SeqCst);
            let steps = Steps { done: (packed >> 32) as u32, tiles: packed as u32 };
            self.observer.keep(film, steps);
        }
    }
}
