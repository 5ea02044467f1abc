//! The file that keeps the field which guides the rays of a frame.

use std::io::{self, Read, Write};
use std::path::PathBuf;

use crate::cli::base::{Exit, Problem, Terminal};
use crate::cli::options::Job;
use crate::cli::system::patience;
use slo_picture::output::{Recipe, open_regular, write_atomically};
use slo_render::guiding::{Field, FieldError, KEY};
use slo_scene::SceneDescription;

/// The file of a frame, if one was asked for.
pub(super) struct GuideFile {
    /// The path, and the key of what the field is learned from.
    file: Option<(PathBuf, [u8; KEY])>,
    terminal: Terminal,
}

impl GuideFile {
    /// The file that a job asks for. A scene that guides no rays has none.
    pub(super) fn new(job: &Job, scene: &SceneDescription, frame: i64, terminal: Terminal) -> Self {
        let path = job.guide_file.as_ref().filter(|_| scene.settings.guide);
        let key = || Recipe { scene, frame }.hash_of_samples();
        Self { file: path.map(|path| (path.of(frame), key())), terminal }
    }

    /// Reads the field, if the file is there and belongs to the frame.
    ///
    /// # Errors
    /// Something else is in the way, or the file can't be read.
    pub(super) fn read(&self) -> Result<Option<Field>, Problem> {
        let Some((path, key)) = &self.file else { return Ok(None) };
        let mut bytes = Vec::new();
        let read = open_regular(path).and_then(|mut file| file.read_to_end(&mut bytes));
        match read {
            Ok(_) => {}
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => {
                let message = format!("can't read `{}`: {error}", path.display());
                return Err(Problem::new(Exit::BadInput, message));
            }
        }
        match Field::from_bytes(&bytes, key) {
            Ok(field) => Ok(Some(field)),
            Err(FieldError::NotAField) => {
                let message =
                    format!("--guide-file `{}`: {}", path.display(), FieldError::NotAField);
                let problem = Problem::new(Exit::Usage, message);
                Err(problem.with_help("move it away, or name another file"))
            }
            Err(error) => {
                let path = path.display();
                self.terminal.warn(format_args!("`{path}` is replaced: {error}"));
                Ok(None)
            }
        }
    }

    /// Writes the field. The picture doesn't need the file, so a failure is only reported.
    pub(super) fn write(&self, field: &Field) {
        let Some((path, key)) = &self.file else { return };
        let bytes = field.to_bytes(key);
        let write = || write_atomically(path, |file| file.write_all(&bytes));
        if let Err(error) = patience::write(path, self.terminal, write) {
            self.terminal.warn(format_args!("can't write `{}`: {error}", path.display()));
        }
    }
}
