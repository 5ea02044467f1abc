//! Which frames of a sequence are to be rendered, and why.

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

/// One frame, and what the output folder holds of it.
#[derive(Debug)]
pub(super) struct Step {
    pub(super) frame: i64,
    /// Where its picture goes; with `--info` the time is still missing.
    pub(super) path: PathBuf,
    pub(super) state: State,
}

/// What is known of a frame before it is rendered.
#[derive(Debug)]
pub(super) enum State {
    /// Its picture is there.
    Finished,
    /// To be rendered, since this is what was found.
    ToRender(Found),
    /// Not to be rendered: the file of another program is there, for this reason.
    Foreign(String),
    /// The scene has no such frame.
    None(NoSegment),
}

/// The frames of a job in the order of their rendering.
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

/// What is there of a frame by now, and where.
pub(super) fn look_again(job: &Job, target: &Target, frame: i64) -> (PathBuf, State) {
    let path = Names::of(job).path(job, target, frame);
    let state = look(job, target, frame, &path);
    (path, state)
}

/// What is at `path` of a frame that the scene has.
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

/// Whether a picture of a run with a time for all frames is to get better.
pub(super) fn is_open(job: &Job, target: &Target, frame: i64) -> bool {
    let state = || unfinished(&target.plain_path(frame), &target.subject(frame), job.is_timed());
    job.total_time.is_some() && state().is_file()
}

/// Names in the output folder, if the time of rendering is part of them.
struct Names(BTreeSet<String>);

impl Names {
    fn of(job: &Job) -> Self {
        let folder = if job.outdir.as_os_str().is_empty() { Path::new(".") } else { &job.outdir };
        let entries = job.info.then(|| std::fs::read_dir(folder)).and_then(Result::ok);
        let names = entries.into_iter().flatten().flatten();
        Self(names.filter_map(|entry| entry.file_name().into_string().ok()).collect())
    }

    /// Where the picture of a frame is, or would be had it taken no time.
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

    /// What is known, in a word or a few.
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
