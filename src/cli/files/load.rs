//! Loads the scene of a job, and builds its frames for rendering.

use std::path::Path;

use super::scene_file::SceneFile;
use super::{built_in, scene_file};
use crate::cli::base::{Exit, Problem, Terminal};
use crate::cli::options::Job;
use slo_accel::Isa;
use slo_picture::output::check_prefix;
use slo_render::frame::{Aids, FrameError, FrameScene};
use slo_scene::animation::NoSegment;
use slo_scene::{Files, Loaded, SceneDescription, ShapeError, load_adapted};

/// Loads the job's scene, and applies the settings of the command line. Prints the errors of the
/// scene, and warnings about what these settings make of it.
pub(crate) fn scene(job: &Job, terminal: Terminal) -> Result<SceneDescription, Problem> {
    let scene = read(job, terminal)?;
    check_prefix(&scene.camera.film.prefix)
        .map_err(|why| Problem::new(Exit::BadInput, format!("the Film's prefix: {why}")))?;
    Ok(scene)
}

fn read(job: &Job, terminal: Terminal) -> Result<SceneDescription, Problem> {
    let loaded = match &job.scene {
        None => {
            let files = Files::built_in(built_in::FOLDER, built_in::FILES);
            let adapt = |scene: &mut SceneDescription| job.overrides.apply(scene);
            load_adapted(built_in::PATH, built_in::text(), &files, &adapt)
        }
        Some(path) => load_file(scene_file::read(path, job)?, job),
    };
    let Loaded { scene, diagnostics } = loaded;
    terminal.show(&diagnostics);
    let exit = if diagnostics.missing_input() { Exit::NoInput } else { Exit::BadInput };
    scene.ok_or_else(|| Problem::told(exit))
}

fn load_file(file: SceneFile, job: &Job) -> Loaded {
    let folder = file.path.parent().unwrap_or(Path::new(""));
    let files = Files::on_disk(folder, &file.root, job.allow_outside);
    let files = files.with_cache(job.cache.clone());
    let adapt = |scene: &mut SceneDescription| job.overrides.apply(scene);
    load_adapted(&file.path.to_string_lossy(), file.text, &files, &adapt)
}

/// Builds what a frame needs, on the threads of the current pool, with the help of what is there.
pub(crate) fn frame(
    isa: Isa,
    scene: &SceneDescription,
    number: i64,
    aids: Aids,
) -> Result<FrameScene, Problem> {
    FrameScene::build_with(scene, number, isa, aids).map_err(no_frame)
}

/// Builds what the light map of an object needs, as [`frame`] does. `None` if the frame does not show
/// the object.
pub(crate) fn light_map(
    job: &Job,
    scene: &SceneDescription,
    number: i64,
    object: usize,
    before: Option<FrameScene>,
) -> Result<Option<FrameScene>, Problem> {
    FrameScene::build_light_map(scene, number, object, job.isa, before).map_err(no_frame)
}

/// Makes the problem that a frame can't be built.
fn no_frame(error: FrameError) -> Problem {
    match error {
        FrameError::NoSegment(error) => no_segment(&error),
        FrameError::Shape { reason: ShapeError::Unreadable { .. }, .. } => {
            Problem::new(Exit::NoInput, error)
        }
        other => Problem::new(Exit::BadInput, other),
    }
}

/// Makes the problem that the camera does not have a frame.
pub(crate) fn no_segment(error: &NoSegment) -> Problem {
    Problem::new(Exit::Usage, error).with_help("choose a frame with `--frame`")
}
