//! Renders a picture as cleanly as a span of time allows.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Instant;

use super::clock::Clock;
use super::lock::lock;
use super::observer::{Exposed, Observer};
use super::photon_map::photon_light;
use super::photons::{Stretch, Stretches};
use super::plan::Plan;
use super::run::Run;
use super::tile::TileRenderer;
use crate::frame::FrameScene;
use slo_picture::film::{Area, Film, Steps, tiles_in_order};
use slo_scene::Integrator;

/// When to stop refining a picture.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// When the time is over.
    pub deadline: Instant,
    /// Steps that are completed however long they take: everything that the film contains already.
    pub least: Steps,
    /// The last step, even if time is left, unless `least` is farther.
    pub last: u32,
}

/// Exposes the film of a whole picture step by step, as far as `budget` allows; the first step is
/// always completed. Returns how far it came: a plan [`in_steps`](Plan::in_steps) of these steps
/// gives the same film without a clock.
///
/// If the observer stops it, tiles may be between two steps. The film can then be continued to the
/// returned steps, or to more.
pub fn render_until(
    frame: &FrameScene,
    plan: &Plan,
    film: Film,
    observer: &dyn Observer,
    budget: Budget,
) -> (Exposed, Steps) {
    let Budget { deadline, least, last } = budget;
    let last = last.max(least.done + u32::from(least.tiles > 0)).min(Steps::LAST);
    let tiles = tiles_in_order(frame.camera.width(), frame.camera.height());
    let run = Run::new(frame, film, plan, observer);
    let clock = Clock::new(deadline, tiles.len(), plan.most());
    let memory: Vec<_> =
        (0..rayon::current_num_threads()).map(|_| Mutex::new(TileRenderer::default())).collect();
    if !run.learn(&|_| observer.advanced(clock.share())) {
        return (run.exposed(false), least);
    }
    let mut reached = Steps::default();
    let gives_up = || observer.gives_up() || observer.should_stop();
    let mut light = None;
    if frame.settings.integrator == Integrator::PhotonMap {
        let start = Instant::now();
        let Some(found) = photon_light(frame, &gives_up) else {
            return (run.exposed(false), reached);
        };
        run.add_photons(found.counts(), start, 1.0);
        light = Some(Arc::new(found));
    }
    for step in least.done.min(last)..=last {
        let plan = plan.at_step(step);
        let mut must = must(least, step, tiles.len());
        let (mut first, mut before) = (None, None);
        if frame.emission.is_some() {
            // Photons serve all tiles, so a step is taken by all tiles or by none.
            if must == 0 {
                if !clock.allows_all(memory.len()) {
                    break;
                }
                before = run.film();
            }
            must = tiles.len();
            first = run.first_open(|_| plan.clone(), &tiles, &memory);
        }
        let mut stretches = Stretches::new(frame, first, light.clone());
        let (mut handed, mut is_open) = (0, true);
        loop {
            let start = Instant::now();
            let Some(stretch) = stretches.next(&plan, &gives_up) else { break };
            if let Some(maps) = &stretch.maps {
                run.add_photons(maps.counts(), start, stretch.share);
            }
            let pass = Pass {
                run: &run,
                clock: &clock,
                tiles: &tiles,
                plan: &plan,
                stretch,
                step,
                must,
                next: AtomicUsize::new(0),
                is_over: AtomicBool::new(false),
                is_stopped: AtomicBool::new(false),
                is_open: AtomicBool::new(false),
            };
            rayon::broadcast(|thread| pass.work(&mut lock(&memory[thread.index()])));
            handed = pass.next.into_inner().min(tiles.len());
            is_open = pass.is_open.into_inner();
            if pass.is_stopped.into_inner() {
                reached = so_far(step, handed, reached);
                return (run.exposed(false), reached);
            }
            if !is_open {
                break;
            }
            // The step takes longer than was expected: the picture is that of the step before.
            if clock.is_over()
                && let Some(film) = before.take()
            {
                run.restore(film);
                return (run.exposed(true), reached);
            }
        }
        if is_open {
            // The observer stopped the tracing of photons.
            return (run.exposed(false), reached);
        }
        reached = so_far(step, handed, reached);
        if handed < tiles.len() {
            break;
        }
        reached = Steps { done: step, tiles: 0 };
    }
    (run.exposed(true), reached)
}

/// Returns how far a picture has come if so many tiles were handed out for a step.
fn so_far(step: u32, handed: usize, before: Steps) -> Steps {
    if step > 0 { Steps { done: step - 1, tiles: handed as u32 } } else { before }
}

/// Returns how many tiles must take a step.
fn must(least: Steps, step: u32, tiles: usize) -> usize {
    match step {
        0 => tiles,
        _ if step <= least.done => tiles,
        _ if step == least.done + 1 => least.tiles as usize,
        _ => 0,
    }
}

/// One step for all tiles.
struct Pass<'a> {
    run: &'a Run<'a>,
    clock: &'a Clock,
    tiles: &'a [Area],
    plan: &'a Plan,
    stretch: Stretch,
    step: u32,
    must: usize,
    /// Number of tiles that were handed out.
    next: AtomicUsize,
    /// Whether to hand out no more tiles.
    is_over: AtomicBool,
    is_stopped: AtomicBool,
    /// Whether any tile needs samples of a later stretch.
    is_open: AtomicBool,
}

impl Pass<'_> {
    /// Takes tiles as long as there is time for another one.
    fn work(&self, renderer: &mut MutexGuard<'_, TileRenderer>) {
        while !self.is_over.load(Ordering::Relaxed) {
            let next = self.next.load(Ordering::Relaxed);
            if next >= self.must && !self.clock.allows(next) {
                self.is_over.store(true, Ordering::Relaxed);
                return;
            }
            let i = self.next.fetch_add(1, Ordering::Relaxed);
            let Some(&tile) = self.tiles.get(i) else { return };
            self.run.note_step(Steps { done: self.step.saturating_sub(1), tiles: i as u32 + 1 });
            let start = Instant::now();
            let Ok(is_done) = self.run.expose(renderer, tile, self.plan, &self.stretch) else {
                self.is_stopped.store(true, Ordering::Relaxed);
                self.is_over.store(true, Ordering::Relaxed);
                return;
            };
            self.is_open.fetch_or(!is_done, Ordering::Relaxed);
            self.clock.add(i, start.elapsed(), renderer.samples());
            self.run.observer.advanced(self.clock.share());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_reached_before_is_reached_again() {
        let least = Steps { done: 3, tiles: 7 };
        let musts: Vec<usize> = (0..7).map(|step| must(least, step, 12)).collect();
        assert_eq!(musts, [12, 12, 12, 12, 7, 0, 0]);
        assert_eq!(must(Steps::default(), 0, 12), 12, "there is a picture in any case");
        assert_eq!(must(Steps::default(), 1, 12), 0);
    }
}
