//! Tiles over threads, adaptive blocks, progress.

use crate::accel::Isa;
use crate::film::Film;
use crate::frame::FrameScene;

/// How to render, beyond what the picture depends on.
#[derive(Clone, Copy, Debug)]
pub struct RenderOptions {
    /// Threads; `None`: the scene's `parallelThreads`, or all that the machine has.
    pub threads: Option<usize>,
    /// Instruction set of the kernels.
    pub isa: Isa,
}

/// Who watches a rendering and may stop it; called from many threads.
pub trait Observer: Sync {
    /// `samples` more camera samples of `pixels` more pixels are done.
    fn advanced(&self, pixels: u64, samples: u64);
    /// Whether to stop at the next tile.
    fn should_stop(&self) -> bool {
        false
    }
}

/// What was traced: counts for the log, never part of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Camera samples taken.
    pub camera_rays: u64,
    /// Rays toward lights.
    pub shadow_rays: u64,
    /// Reflected and refracted rays.
    pub bounce_rays: u64,
    /// Contributions that were not finite or out of the film's range, left out of the sums.
    pub refused_contributions: u64,
}

/// The rendering was stopped by its observer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stopped;

/// Renders the whole picture of a frame.
///
/// # Errors
/// [`Stopped`] when the observer asked for it.
pub fn render(
    _frame: &FrameScene,
    _options: &RenderOptions,
    _observer: &dyn Observer,
) -> Result<(Film, Statistics), Stopped> {
    Err(Stopped)
}
