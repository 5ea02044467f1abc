//! Who watches a rendering, and what comes of it.

use slo_picture::film::{Film, Steps};

use crate::integrator::Statistics;

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
