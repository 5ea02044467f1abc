//! The rendering that is asked for.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use super::overrides::Overrides;
use crate::cli::base::{Exit, Problem};
use crate::cli::values::{
    FrameChoice, FramePath, Frames, Maps, Order, PartBy, ProgressForm, Region,
};
use slo_accel::Isa;
use slo_accel::study::Parameters;
use slo_picture::film::Steps;
use slo_render::render::Part;
use slo_scene::SceneDescription;
use slo_scene::animation::Clock;
use slo_scene::cache::Cache;

/// Frames of a scene, and how to render them.
#[derive(Clone, Debug)]
pub(crate) struct Job {
    /// The scene file; `None`: the built-in scene.
    pub(crate) scene: Option<PathBuf>,
    /// Folder that `scene` lies in and that its paths may not leave.
    pub(crate) indir: Option<PathBuf>,
    /// Whether the paths of the scene may lead anywhere.
    pub(crate) allow_outside: bool,
    /// The frames asked for; `None`: frame 0.
    pub(crate) frames: Option<FrameChoice>,
    pub(crate) order: Order,
    /// Whether other processes render the same frames, and how long each may go without a sign of
    /// life.
    pub(crate) share: Option<Duration>,
    /// Region of the picture to render; `None`: all of it.
    pub(crate) region: Option<Region>,
    /// Part that this run renders, and what the parts divide; `None`: everything.
    pub(crate) part: Option<(Part, PartBy)>,
    /// Folder of the pictures; empty: the current folder.
    pub(crate) outdir: PathBuf,
    /// Whether the pictures' names contain the settings and the time.
    pub(crate) info: bool,
    pub(crate) existing: Existing,
    /// Time between two checkpoints; `None`: a checkpoint only when a frame is stopped.
    pub(crate) checkpoint: Option<Duration>,
    /// Whether finished frames can get more samples later.
    pub(crate) keep_state: bool,
    pub(crate) maps: Maps,
    /// File that keeps the field which guides rays.
    pub(crate) guide_file: Option<FramePath>,
    /// Host and port of the viewer that shows pictures while they are rendered.
    pub(crate) display_server: Option<String>,
    /// How long a frame may take; `None`: as long as its samples take.
    pub(crate) time: Option<Duration>,
    /// How long all frames together may take.
    pub(crate) total_time: Option<Duration>,
    /// Steps to which a frame is taken, instead of the scene's rule.
    pub(crate) steps: Option<Steps>,
    /// Whether to list what would be rendered instead of rendering it.
    pub(crate) dry_run: bool,
    /// Whether frames are rendered again whenever the scene changes.
    pub(crate) watch: bool,
    pub(crate) progress: ProgressForm,
    pub(crate) overrides: Overrides,
    pub(crate) threads: Option<usize>,
    /// Folder of what was worked out before.
    pub(crate) cache: Option<Arc<Cache>>,
    pub(crate) isa: Isa,
}

/// What happens to an existing picture that is complete and has the same recipe. A file that
/// slo-rt did not make is replaced only with [`Existing::Overwrite`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Existing {
    /// It is kept in a sequence, and overwritten if a single frame was asked for.
    #[default]
    Auto,
    Skip,
    Overwrite,
}

impl Job {
    /// Returns the frames to render. The job must be made [for a scene](Self::for_scene).
    pub(crate) fn frames(&self) -> Frames {
        match &self.frames {
            Some(FrameChoice::These(frames)) => frames.clone(),
            Some(FrameChoice::All) | None => Frames::single(0),
        }
    }

    /// Returns the same job with the frames that the scene has.
    ///
    /// # Errors
    /// All frames are asked for, but the scene has none, or too many for one run.
    pub(crate) fn for_scene(&self, scene: &SceneDescription) -> Result<Self, Problem> {
        let mut job = self.clone();
        if job.frames == Some(FrameChoice::All) {
            let ranges = Clock::new(&scene.camera).segments().map(|s| s.first..=s.last).collect();
            let frames = Frames::of_ranges(ranges).map_err(|why| {
                Problem::new(Exit::Usage, format!("`--frame all`: {why}"))
                    .with_help("choose frames with `--frame`, such as `--frame 1-100`")
            })?;
            job.frames = Some(FrameChoice::These(frames));
        }
        Ok(job)
    }

    /// Returns the parameters of structures to study.
    pub(crate) fn parameters(&self) -> Parameters {
        self.overrides.settings.accelerator_options.unwrap_or_default()
    }

    /// Whether the clock decides how far a frame is taken.
    pub(crate) fn is_timed(&self) -> bool {
        self.time.is_some() || self.total_time.is_some()
    }

    /// Whether files are replaced even if another program made them.
    pub(crate) fn overwrites(&self) -> bool {
        self.existing == Existing::Overwrite
    }

    /// Whether frames that are finished already are left alone.
    pub(crate) fn skips_finished(&self) -> bool {
        match self.existing {
            Existing::Auto => self.frames.as_ref().is_some_and(FrameChoice::is_sequence),
            Existing::Skip => true,
            Existing::Overwrite => false,
        }
    }
}
