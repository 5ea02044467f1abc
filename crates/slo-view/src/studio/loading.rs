//! The text of the scene, and the scene that it describes.

use std::borrow::Cow;
use std::path::Path;
use std::time::Duration;

use slo_scene::diagnostics::Diagnostics;
use slo_scene::edit::Edit;
use slo_scene::files::Opened;
use slo_scene::{KnownFiles, Loaded, SceneDescription};

use crate::document::{Document, Outside};
use crate::source::Source;
use crate::watched::Watched;

/// Time after which a file that is being written is looked at again, and how often at most.
const WAIT: Duration = Duration::from_millis(20);
const MOST_WAITS: usize = 25;
const NOT_TEXT: &str = "the text is not UTF-8, so it can't be changed from here";

/// The text of the scene, and what was said about it.
pub(crate) struct Loading {
    source: Box<dyn Source>,
    document: Document,
    /// Meshes beside the scene.
    files: Vec<String>,
    /// Meshes and images, which edits of the text leave as they are.
    known: KnownFiles,
    /// The file of the scene.
    own: Watched,
    /// The other files that it uses.
    others: Watched,
    diagnostics: Diagnostics,
    /// What is said about the file, while the person has to choose between it and the text.
    of_file: Option<Diagnostics>,
    /// Why the text can't be read.
    unreadable: Option<String>,
    /// Whether the text can be changed: whether it is UTF-8.
    is_text: bool,
    /// Whether the text has changed since the scene was made of it.
    is_stale: bool,
}

impl Loading {
    pub(super) fn new(source: Box<dyn Source>) -> Self {
        let mut loading = Self {
            source,
            document: Document::default(),
            files: Vec::new(),
            known: KnownFiles::default(),
            own: Watched::default(),
            others: Watched::default(),
            diagnostics: Diagnostics::default(),
            of_file: None,
            unreadable: None,
            is_text: true,
            is_stale: true,
        };
        loading.read();
        loading
    }

    /// What messages call the scene.
    pub(crate) fn name(&self) -> String {
        self.source.name()
    }

    /// Whether the scene has a file.
    pub(crate) fn has_file(&self) -> bool {
        self.source.path().is_some()
    }

    /// Files beside the scene that can be added to it, as it writes their paths.
    pub(crate) fn files(&self) -> &[String] {
        &self.files
    }

    /// The text.
    pub(crate) fn document(&self) -> &Document {
        &self.document
    }

    /// Errors and warnings about the text.
    pub(crate) fn diagnostics(&self) -> &Diagnostics {
        &self.diagnostics
    }

    /// Errors and warnings about the file, while the person has to choose between it and the text.
    pub(crate) fn of_file(&self) -> Option<&Diagnostics> {
        self.of_file.as_ref().filter(|_| self.document.has_conflict())
    }

    /// Why the text can't be read.
    pub(crate) fn unreadable(&self) -> Option<&str> {
        self.unreadable.as_deref()
    }

    /// Looks at the files of the scene. Returns whether it has to be loaded again.
    pub(super) fn glance(&mut self) -> bool {
        let (mut others, mut own) = (self.others.have_changed(), self.own.have_changed());
        // Whoever is writing a file may finish it: half a text would be full of errors.
        for _ in 0..MOST_WAITS {
            if !others && !own {
                return false;
            }
            std::thread::sleep(WAIT);
            let again = [self.others.have_changed(), self.own.have_changed()];
            if again == [false; 2] {
                break;
            }
            (others, own) = (others || again[0], own || again[1]);
        }
        let own = own && self.read();
        others || own
    }

    /// Reads the file. Returns whether the text is another one.
    fn read(&mut self) -> bool {
        // Looked at before it is read: a change meanwhile is noticed.
        self.own = Watched::new(self.source.path().map(std::path::Path::to_owned));
        let bytes = match self.source.read() {
            Ok(bytes) => bytes,
            Err(error) => {
                self.unreadable = Some(format!("can't read the scene: {error}"));
                return false;
            }
        };
        let was_unreadable = self.unreadable.take().is_some();
        let text = String::from_utf8_lossy(&bytes);
        self.is_text = matches!(text, Cow::Borrowed(_));
        let outside = self.document.read(&text);
        let is_new = outside == Outside::Taken;
        self.is_stale |= is_new;
        if outside == Outside::Conflict {
            // Its errors are part of the choice.
            let loaded = self.source.load(&bytes, &Opened::default(), &self.known);
            self.of_file = Some(loaded.diagnostics);
        }
        is_new || was_unreadable
    }

    /// Makes the scene of the text. `None` if it has errors.
    pub(super) fn load(&mut self) -> Option<SceneDescription> {
        if self.unreadable.is_some() {
            return None;
        }
        let opened = Opened::default();
        let bytes = self.document.bytes();
        let Loaded { scene, diagnostics } = self.source.load(&bytes, &opened, &self.known);
        self.others = Watched::new(opened.paths());
        self.files = self.source.path().map(meshes_beside).unwrap_or_default();
        self.diagnostics = diagnostics;
        self.is_stale = false;
        scene
    }

    /// Whether the scene is not of the text as it is now.
    pub(super) fn is_stale(&self) -> bool {
        self.is_stale
    }

    /// Changes the text.
    ///
    /// # Errors
    /// It can't be changed, or the changes do not fit it.
    pub(super) fn change(
        &mut self,
        edits: Vec<Edit>,
        what: &str,
        join: bool,
    ) -> Result<(), String> {
        if !self.is_text {
            return Err(NOT_TEXT.into());
        }
        self.is_stale = true;
        self.document.change(edits, what, join)
    }

    /// Takes a text that was made of a text before: all steps of one movement are one change.
    ///
    /// # Errors
    /// The text can't be changed.
    pub(super) fn replace(&mut self, text: String, what: &str) -> Result<(), String> {
        if !self.is_text {
            return Err(NOT_TEXT.into());
        }
        self.is_stale = true;
        self.document.replace(text, what, true);
        Ok(())
    }

    /// What is changed from now on is another step.
    pub(super) fn seal(&mut self) {
        self.document.seal();
    }

    /// Changes the text by its history.
    pub(super) fn step(&mut self, step: impl FnOnce(&mut Document)) {
        step(&mut self.document);
        self.is_stale = true;
    }

    /// Saves the text; with errors only if the person wants that.
    ///
    /// # Errors
    /// It can't be saved, or has errors.
    pub(super) fn save(&mut self, with_errors: bool) -> Result<(), String> {
        if self.diagnostics.has_errors() && !with_errors {
            return Err("the text has errors; it is not saved unless you say so".into());
        }
        let path = self.source.path().ok_or("the built-in scene can't be saved")?;
        self.document.save(path)
    }
}

/// Most files that are offered.
const MOST_FILES: usize = 200;

/// Meshes in the folder of a scene, and in the folders in it.
fn meshes_beside(scene: &Path) -> Vec<String> {
    let folder = scene.parent().unwrap_or(Path::new(""));
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let mut found = Vec::new();
    let mut look = |folder: &Path, before: &str| {
        let mut folders = Vec::new();
        for entry in folder.read_dir().into_iter().flatten().flatten().take(10 * MOST_FILES) {
            let Ok(name) = entry.file_name().into_string() else { continue };
            let is_mesh = [".slo", ".obj", ".ply"].iter().any(|end| name.ends_with(end));
            match entry.file_type() {
                Ok(kind) if kind.is_dir() => folders.push(name),
                Ok(_) if is_mesh && found.len() < MOST_FILES => {
                    found.push(format!("{before}{name}"))
                }
                _ => {}
            }
        }
        folders
    };
    for name in look(folder, "") {
        look(&folder.join(&name), &format!("{name}/"));
    }
    found.sort();
    found
}
