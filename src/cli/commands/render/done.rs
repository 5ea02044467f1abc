//! Result of a frame: its times, its size, and the path of its picture.

use std::path::PathBuf;
use std::time::Duration;

use crate::cli::base::{Exit, Problem};
use slo_picture::film::Steps;
use slo_picture::output::Outcome;
use slo_render::frame::FrameScene;
use slo_render::render::Statistics;

/// Durations of the phases.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Times {
    pub(super) loading: Duration,
    pub(super) building: Duration,
    /// Of the photons, before and between samples.
    pub(super) photons: Duration,
    pub(super) rendering: Duration,
    pub(super) writing: Duration,
}

impl Times {
    /// Adds the times of a frame, except loading: the scene is loaded once for all frames.
    pub(super) fn add(&mut self, frame: &Self) {
        self.building += frame.building;
        self.photons += frame.photons;
        self.rendering += frame.rendering;
        self.writing += frame.writing;
    }

    /// Returns the time of all phases.
    pub(super) fn total(&self) -> Duration {
        self.loading + self.building + self.photons + self.rendering + self.writing
    }
}

/// When a picture is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// Between the rendering of two frames.
    Between,
    /// While the next frame is rendered.
    Beside,
}

/// Size of a frame.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Size {
    pub(super) primitives: usize,
    pub(super) moving_objects: usize,
    /// Memory of the structures in bytes.
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
    /// Pixels that are brighter than the film can say.
    pub(super) full_pixels: usize,
    pub(super) outcome: Outcome,
    /// Problem of a file beside the picture that could not be written.
    pub(super) missing: Option<Problem>,
    /// How far the frame was taken, if the clock decided it.
    pub(super) steps: Option<Steps>,
}

impl Done {
    /// Adds the times and statistics of an earlier visit to the frame.
    pub(super) fn after(mut self, earlier: &Self) -> Self {
        self.times.add(&earlier.times);
        self.statistics += earlier.statistics;
        self
    }
}

/// Returns the exit code for failed frames: their own if `all` frames failed with the same code,
/// and [`Exit::Failed`] otherwise.
pub(super) fn exit_of(failures: &[(i64, Problem)], all: bool) -> Exit {
    let first = failures[0].1.exit;
    let alike = failures.iter().all(|(_, problem)| problem.exit == first);
    if all && alike { first } else { Exit::Failed }
}
