//! What came of a frame: how long it took, how much there was in it, where its picture is.

use std::path::PathBuf;
use std::time::Duration;

use crate::cli::base::{Exit, Problem};
use slo_picture::film::Steps;
use slo_picture::output::Outcome;
use slo_render::frame::FrameScene;
use slo_render::render::Statistics;

/// How long the phases took.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Times {
    pub(super) loading: Duration,
    pub(super) building: Duration,
    pub(super) rendering: Duration,
    pub(super) writing: Duration,
}

impl Times {
    /// Adds the times of a frame; its scene is loaded once for all.
    pub(super) fn add(&mut self, frame: &Self) {
        self.building += frame.building;
        self.rendering += frame.rendering;
        self.writing += frame.writing;
    }

    /// All phases.
    pub(super) fn total(&self) -> Duration {
        self.loading + self.building + self.rendering + self.writing
    }
}

/// How much there is in a frame.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Size {
    pub(super) primitives: usize,
    pub(super) moving_objects: usize,
    /// Bytes of the structures.
    pub(super) structures: u64,
}

impl Size {
    pub(super) fn of(frame: &FrameScene) -> Self {
        Self {
            primitives: frame.primitives(),
            moving_objects: frame.moving_objects(),
            structures: frame.memory() as u64,
        }
    }
}

/// A frame whose picture is in place.
#[derive(Debug)]
pub(super) struct Done {
    pub(super) path: PathBuf,
    pub(super) times: Times,
    pub(super) statistics: Statistics,
    pub(super) size: Size,
    pub(super) outcome: Outcome,
    /// A file beside the picture that could not be written.
    pub(super) missing: Option<Problem>,
    /// How far it was taken, if the clock decided about that.
    pub(super) steps: Option<Steps>,
}

impl Done {
    /// The same with what an earlier visit to the frame took.
    pub(super) fn after(mut self, earlier: &Self) -> Self {
        self.times.add(&earlier.times);
        self.statistics += earlier.statistics;
        self
    }
}

/// Exit code of frames that failed: their own if `all` frames failed alike, and otherwise
/// [`Exit::Failed`].
pub(super) fn exit_of(failures: &[(i64, Problem)], all: bool) -> Exit {
    let first = failures[0].1.exit;
    let alike = failures.iter().all(|(_, problem)| problem.exit == first);
    if all && alike { first } else { Exit::Failed }
}
