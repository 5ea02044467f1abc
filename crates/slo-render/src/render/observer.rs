//! Who watches a rendering, and what comes of it.

use std::time::Duration;

use slo_picture::film::{Film, Steps};

use crate::guiding::Field;
use crate::integrator::Statistics;

/// Watches a rendering and may stop it. Called from many threads.
pub trait Observer: Sync {
    /// Reports a further share of the picture that is done; the whole picture is 1.
    fn advanced(&self, share: f64);
    /// Reports a share of the picture that was done by an earlier run. Counts as advanced by
    /// default.
    fn resumed(&self, share: f64) {
        self.advanced(share);
    }
    /// Reports that `time` went into the photons that the next `share` of the picture uses.
    fn prepared(&self, time: Duration, share: f64) {
        let _ = (time, share);
    }
    /// Receives the field that guides rays, as soon as it is learned.
    fn learned(&self, field: &Field) {
        let _ = field;
    }
    /// Receives a tile after each of its steps.
    fn exposed(&self, tile: &Film) {
        let _ = tile;
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
