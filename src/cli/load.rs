//! From a job to a scene that can be rendered.

use std::path::Path;

use rayon::{ThreadPool, ThreadPoolBuilder};

use super::options::Job;
use super::problem::Problem;
use super::scene_file::{self, SceneFile};
use super::terminal::Terminal;
use super::{Exit, default_scene};
use crate::animation::NoSegment;
use crate::frame::{FrameError, FrameScene};
use crate::output::check_prefix;
use crate::scene::{Files, Loaded, SceneDescription, load};

/// More threads than this for each processor are taken as this many: they would do nothing but look
/// for work in each other's queues, which takes ever longer.
const MOST_THREADS_PER_PROCESSOR: usize = 16;

/// Threads for a job: as many as asked for, or as the machine has.
pub(super) fn threads(asked: Option<usize>) -> Result<ThreadPool, Problem> {
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let most = processors.saturating_mul(MOST_THREADS_PER_PROCESSOR);
    let threads = asked.map_or(0, |threads| threads.min(most));
    ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|error| Problem::new(Exit::Failed, format!("can't start threads: {error}")))
}

/// The job's scene, with what the command line says over it. Errors and warnings of the scene
/// are said.
pub(super) fn scene(job: &Job, terminal: Terminal) -> Result<SceneDescription, Problem> {
    let mut scene = read(job, terminal)?;
    job.overrides.apply(&mut scene);
    check_prefix(&scene.camera.film.prefix)
        .map_err(|why| Problem::new(Exit::BadInput, format!("the Film's prefix: {why}")))?;
    Ok(scene)
}

fn read(job: &Job, terminal: Terminal) -> Result<SceneDescription, Problem> {
    let loaded = match &job.scene {
        None => {
            let files = Files::built_in(default_scene::FOLDER, default_scene::FILES);
            load(default_scene::PATH, default_scene::text(), &files)
        }
        Some(path) => load_file(scene_file::read(path, job)?, job.allow_outside),
    };
    let Loaded { scene, diagnostics } = loaded;
    terminal.show(&diagnostics);
    let exit = if diagnostics.missing_input() { Exit::NoInput } else { Exit::BadInput };
    scene.ok_or_else(|| Problem::told(exit))
}

fn load_file(file: SceneFile, allow_outside: bool) -> Loaded {
    let folder = file.path.parent().unwrap_or(Path::new(""));
    let files = Files::on_disk(folder, &file.root, allow_outside);
    load(&file.path.to_string_lossy(), file.text, &files)
}

/// What a frame needs, built on the threads of the current pool; what it has in common with one
/// `before` is taken from there.
pub(super) fn frame(
    job: &Job,
    scene: &SceneDescription,
    number: i64,
    before: Option<FrameScene>,
) -> Result<FrameScene, Problem> {
    FrameScene::build_after(scene, number, job.isa, before).map_err(|error| match error {
        FrameError::NoSegment(error) => no_segment(&error),
        other => Problem::new(Exit::BadInput, other),
    })
}

/// A frame that the camera does not have.
pub(super) fn no_segment(error: &NoSegment) -> Problem {
    Problem::new(Exit::Usage, error).with_help("`--frame` names the frame")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_are_as_many_as_asked_for_but_never_a_crowd() {
        let count = |asked| threads(asked).unwrap().current_num_threads();
        assert_eq!(count(Some(3)), 3);
        let processors = std::thread::available_parallelism().map_or(1, usize::from);
        assert_eq!(count(Some(65536)), MOST_THREADS_PER_PROCESSOR * processors);
    }
}
