//! Tiles over threads, adaptive blocks, progress.

mod adaptive;
mod sections;
mod tile;

use std::sync::Mutex;

use rayon::prelude::*;

use crate::film::{Area, Film, TooLarge};
use crate::frame::FrameScene;
pub use crate::integrator::Statistics;
use sections::Sections;
use tile::TileRenderer;

/// Who watches a rendering and may stop it; called from many threads.
pub trait Observer: Sync {
    /// `pixels` more pixels are done, with `samples` camera samples.
    fn advanced(&self, pixels: u64, samples: u64);
    /// Whether to stop at the next tile.
    fn should_stop(&self) -> bool {
        false
    }
}

/// Why there is no picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unfinished {
    /// The observer asked to stop.
    Stopped,
    /// Memory does not hold the film.
    TooLarge(TooLarge),
}

impl From<TooLarge> for Unfinished {
    fn from(error: TooLarge) -> Self {
        Self::TooLarge(error)
    }
}

/// Renders the whole picture of a frame on the threads of the current rayon pool.
///
/// # Errors
/// [`Unfinished`] when the observer asked to stop, or memory does not suffice.
pub fn render(
    frame: &FrameScene,
    observer: &dyn Observer,
) -> Result<(Film, Statistics), Unfinished> {
    let (width, height) = (frame.camera.width(), frame.camera.height());
    let result = Mutex::new((Film::new(width, height)?, Statistics::default()));
    // One set of working memory per thread; a tile never waits for another inside its thread.
    let memory: Vec<_> =
        (0..rayon::current_num_threads()).map(|_| Mutex::new(TileRenderer::default())).collect();
    let render_tile = |area: Area| {
        if observer.should_stop() {
            return Err(Unfinished::Stopped);
        }
        let thread = rayon::current_thread_index().unwrap_or(0);
        let mut renderer = lock(&memory[thread]);
        let (pixels, statistics) = renderer.render(frame, area);
        let samples = pixels.iter().map(|p| u64::from(p.samples)).sum();
        {
            let mut result = lock(&result);
            result.0.put(area, pixels);
            result.1 += statistics;
        }
        observer.advanced(area.len() as u64, samples);
        Ok(())
    };
    // Threads take sections, and when none is left steal tiles of others' sections.
    let sections = Sections::new(&frame.settings, width, height);
    sections
        .areas()
        .into_par_iter()
        .with_max_len(frame.settings.sections_per_thread.max(1) as usize)
        .try_for_each(|section| {
            sections::tiles(section).into_par_iter().with_max_len(1).try_for_each(render_tile)
        })?;
    Ok(result.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner()))
}

/// Sums are whole at every moment, so a panic elsewhere leaves nothing broken behind a lock.
fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}
