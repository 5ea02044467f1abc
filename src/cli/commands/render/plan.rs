//! Decides which frames of a sequence are to be rendered, and why.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Duration;

use rayon::prelude::*;

use super::target::Target;
use crate::cli::files::checkpoint::unfinished;
use crate::cli::options::Job;
use slo_picture::output::Found;
use slo_scene::SceneDescription;
use slo_scene::animation::{Clock, NoSegment};

/// A frame, and what the output folder holds for it.
#[derive(Debug)]
pub(super) struct Step {
    pub(super) frame: i64,
    /// Path of its picture. With `--info`, the render time is not known yet.
    pub(super) path: PathBuf,
    pub(super) state: State,
}

/// What is known about a frame before it is rendered.
#[derive(Debug)]
pub(super) enum State {
    /// Its picture is finished.
    Finished,
    /// To be rendered because of what was found.
    ToRender(Found),
    /// Not to be rendered: another program's file is there. The text says why it counts as such.
    Foreign(String),
    /// The scene has no such frame.
    None(NoSegment),
}

/// Returns the frames of a job in the order of their rendering.
pub(super) fn steps(job: &Job, scene: &SceneDescription, target: &Target) -> Vec<Step> {
    let (clock, names) = (Clock::new(&scene.camera), Names::of(job));
    let step = |frame: i64| {
        let path = names.path(job, target, frame);
        let state = match clock.shutter(frame) {
            Err(error) => State::None(error),
            Ok(_) => look(job, target, frame, &path),
        };
        Step { frame, path, state }
    };
    job.order.of(&job.frames().numbers).into_par_iter().map(step).collect()
}

/// Looks again at what exists of a frame by now, and returns its path and state.
pub(super) fn look_again(job: &Job, target: &Target, frame: i64) -> (PathBuf, State) {
    let path = Names::of(job).path(job, target, frame);
    let state = look(job, target, frame, &path);
    (path, state)
}

/// Looks at the file at `path` of a frame that the scene has.
fn look(job: &Job, target: &Target, frame: i64, path: &Path) -> State {
    match target.look(frame, path) {
        Found::Finished if is_open(job, target, frame) => {
            State::ToRender(Found::Stale("the time was not over".into()))
        }
        Found::Finished if job.skips_finished() => State::Finished,
        Found::Foreign(why) if !job.overwrites() => State::Foreign(why),
        found => State::ToRender(found),
    }
}

/// Whether a picture of a run with a time for all frames is to improve further.
pub(super) fn is_open(job: &Job, target: &Target, frame: i64) -> bool {
    let state = || unfinished(&target.plain_path(frame), &target.subject(frame), job.is_timed());
    job.total_time.is_some() && state().is_file()
}

/// Names in the output folder, if they contain the render time; empty otherwise.
struct Names(BTreeSet<String>);

impl Names {
    fn of(job: &Job) -> Self {
        let folder = if job.outdir.as_os_str().is_empty() { Path::new(".") } else { &job.outdir };
        let entries = job.info.then(|| std::fs::read_dir(folder)).and_then(Result::ok);
        let names = entries.into_iter().flatten().flatten();
        Self(names.filter_map(|entry| entry.file_name().into_string().ok()).collect())
    }

    /// Returns the path of a frame's picture, or the path that it would have if rendering took no
    /// time.
    fn path(&self, job: &Job, target: &Target, frame: i64) -> PathBuf {
        let path = target.path(frame, Duration::ZERO);
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let there = name.split_once("_time=").and_then(|(before, _)| {
            let start = format!("{before}_time=");
            self.0.range(start.clone()..).next().filter(|there| there.starts_with(&start))
        });
        there.map_or_else(|| path.clone(), |name| job.outdir.join(name))
    }
}

impl Step {
    pub(super) fn is_to_render(&self) -> bool {
        matches!(self.state, State::ToRender(_))
    }

    /// Describes the state in a few words.
    pub(super) fn reason(&self) -> String {
        match &self.state {
            State::Finished => "finished".into(),
            State::None(_) => "no such frame".into(),
            State::Foreign(why) => format!("foreign ({why})"),
            State::ToRender(Found::Finished | Found::Foreign(_)) => "to be overwritten".into(),
            State::ToRender(Found::Missing) => "missing".into(),
            State::ToRender(Found::Damaged) => "damaged".into(),
            State::ToRender(Found::Stale(difference)) => format!("stale ({difference})"),
        }
    }
}
