//! Loads the scene of a job, and builds its frames for rendering.

use std::io;
use std::path::{Path, PathBuf};

use super::scene_file::SceneFile;
use super::{built_in, scene_file};
use crate::cli::base::{Exit, Problem, Terminal};
use crate::cli::options::Job;
use slo_accel::Isa;
use slo_picture::output::check_prefix;
use slo_render::frame::{Aids, FrameError, FrameScene};
use slo_scene::animation::NoSegment;
use slo_scene::files::{Drafts, Opened};
use slo_scene::{Files, KnownFiles, Loaded, SceneDescription, ShapeError, load_adapted};

/// Loads the job's scene, and applies the settings of the command line. Prints the errors of the
/// scene, and warnings about what these settings make of it.
pub(crate) fn scene(job: &Job, terminal: Terminal) -> Result<SceneDescription, Problem> {
    noted(job, terminal, &Opened::default())
}

/// Loads the job's scene as [`scene`] does, and notes the files on disk that it names.
pub(crate) fn noted(
    job: &Job,
    terminal: Terminal,
    opened: &Opened,
) -> Result<SceneDescription, Problem> {
    let scene = read(job, terminal, opened)?;
    check_prefix(&scene.camera.film.prefix)
        .map_err(|why| Problem::new(Exit::BadInput, format!("the Film's prefix: {why}")))?;
    Ok(scene)
}

fn read(job: &Job, terminal: Terminal, opened: &Opened) -> Result<SceneDescription, Problem> {
    let loaded = load(&file(job)?, job, opened.clone(), None);
    let Loaded { scene, diagnostics } = loaded;
    terminal.show(&diagnostics);
    let exit = if diagnostics.missing_input() { Exit::NoInput } else { Exit::BadInput };
    scene.ok_or_else(|| Problem::told(exit))
}

/// Reads the text of the job's scene.
pub(crate) fn file(job: &Job) -> Result<SceneFile, Problem> {
    match &job.scene {
        None => Ok(SceneFile {
            path: built_in::PATH.into(),
            root: PathBuf::new(),
            text: built_in::text().to_owned(),
        }),
        Some(path) => scene_file::read(path, job),
    }
}

/// What scenes have left that were loaded before.
#[derive(Debug)]
pub(crate) struct Remains {
    /// Their files.
    pub(crate) known: KnownFiles,
    /// Files that are not on disk yet.
    pub(crate) drafts: Drafts,
}

/// Loads the scene that a text describes, and applies the settings of the command line. Notes the files
/// on disk that it names. `remains` is what scenes before it have left.
pub(crate) fn load(
    file: &SceneFile,
    job: &Job,
    opened: Opened,
    remains: Option<Remains>,
) -> Loaded {
    let files = files(file, job).noted_in(opened);
    let files = match remains {
        Some(Remains { known, drafts }) => files.with_known(known).with_drafts(drafts),
        None => files,
    };
    let adapt = |scene: &mut SceneDescription| job.overrides.apply(scene);
    load_adapted(&file.path.to_string_lossy(), &file.text, &files, &adapt)
}

/// Returns the files that a scene may name.
fn files(file: &SceneFile, job: &Job) -> Files {
    match &job.scene {
        None => Files::built_in(built_in::FOLDER, built_in::FILES),
        Some(_) => {
            let folder = file.path.parent().unwrap_or(Path::new(""));
            Files::on_disk(folder, &file.root, job.allow_outside).with_cache(job.cache.clone())
        }
    }
}

/// Reads a text file by its path as the scene of the job would write it.
///
/// # Errors
/// It can't be read, or the scene may not read it; with what to say about it.
pub(crate) fn open(file: &SceneFile, job: &Job, path: &str) -> Result<Vec<u8>, String> {
    let reader = files(file, job).open(path).map_err(|error| error.about(path))?;
    scene_file::limited(reader).map_err(|error| match error.kind() {
        io::ErrorKind::FileTooLarge => format!("`{path}` is no scene: it is longer than 256 MiB"),
        _ => format!("can't read `{path}`: {error}"),
    })
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
pub(crate) fn no_frame(error: FrameError) -> Problem {
    match error {
        FrameError::NoSegment(error) => no_segment(&error),
        FrameError::Shape { reason: ShapeError::Unreadable { .. }, .. } => {
            Problem::new(Exit::NoInput, error)
        }
        FrameError::Device { .. } => Problem::new(Exit::Unavailable, error)
            .with_help("`--accelerator BVH` renders the same picture on the CPU"),
        FrameError::Memory { help, .. } => Problem::new(Exit::Failed, error).with_help(help),
        other => Problem::new(Exit::BadInput, other),
    }
}

/// Makes the problem that the camera does not have a frame.
pub(crate) fn no_segment(error: &NoSegment) -> Problem {
    Problem::new(Exit::Usage, error).with_help("choose a frame with `--frame`")
}
