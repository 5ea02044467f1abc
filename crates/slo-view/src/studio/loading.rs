//! The text of the scene, and the scene that it describes.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use std::time::Duration;

use slo_picture::output::write_new;
use slo_scene::diagnostics::Diagnostics;
use slo_scene::edit::Edit;
use slo_scene::files::{Draft, Drafts, Opened};
use slo_scene::{KnownFiles, Loaded, SceneDescription};

use super::offers::Offers;
use crate::document::{Document, Outside};
use crate::sculpting::{Sculptures, free_name, renamed};
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
    /// Files beside the scene.
    offers: Offers,
    /// Meshes and images, which edits of the text leave as they are.
    known: KnownFiles,
    /// The contents of meshes that are no files yet.
    drafts: BTreeMap<String, Draft>,
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
            offers: Offers::default(),
            known: KnownFiles::default(),
            drafts: BTreeMap::new(),
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

    /// The command that explains a pixel again.
    pub(super) fn replay(&self, pixel: [u32; 2], frame: i64, size: Option<[u32; 2]>) -> String {
        self.source.replay(pixel, frame, size)
    }

    /// Whether the scene has a file.
    pub(crate) fn has_file(&self) -> bool {
        self.source.path().is_some()
    }

    /// Files beside the scene that can be added to it, as it writes their paths.
    pub(crate) fn files(&self) -> &[String] {
        &self.offers.meshes
    }

    /// Scenes beside the scene, as it would write their paths.
    pub(crate) fn scenes(&self) -> &[String] {
        &self.offers.scenes
    }

    /// Reads the text of another scene.
    pub(super) fn open(&self, path: &str) -> Result<String, String> {
        let text = String::from_utf8(self.source.open(path)?);
        let text = text.map_err(|_| format!("`{path}` is no scene: it is not UTF-8"))?;
        Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
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
            let none = Drafts::default();
            let loaded = self.source.load(&bytes, &Opened::default(), &self.known, &none);
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
        let drafts = self.drafts();
        let loaded = self.source.load(&bytes, &opened, &self.known, &drafts);
        let Loaded { scene, diagnostics } = loaded;
        self.others = Watched::new(opened.paths());
        if let Some(path) = self.source.path() {
            self.offers.renew(path);
        }
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
        let path = self.source.path().ok_or("the built-in scene can't be saved")?.to_owned();
        self.document.check(&path)?;
        self.save_meshes(path.parent().unwrap_or(Path::new("")))?;
        self.document.save(&path)?;
        self.document.keep_meshes();
        Ok(())
    }

    /// Takes a text, and meshes that are no files yet: all steps of one movement are one change.
    ///
    /// # Errors
    /// The text can't be changed.
    pub(super) fn sculpt(
        &mut self,
        text: String,
        meshes: Sculptures,
        what: &str,
    ) -> Result<(), String> {
        if !self.is_text {
            return Err(NOT_TEXT.into());
        }
        self.is_stale = true;
        self.document.sculpt(text, meshes, what, true);
        Ok(())
    }

    /// Whether a file beside the scene may get a name.
    pub(super) fn is_free(&self, name: &str) -> bool {
        let text = self.document.text();
        let is_there = |path: &Path| path.parent().unwrap_or(Path::new("")).join(name).exists();
        self.document.meshes().get(name).is_none()
            && renamed(text, name, name).1 == 0
            && !self.source.path().is_some_and(is_there)
    }

    /// The contents of meshes that are no files yet.
    fn drafts(&mut self) -> Drafts {
        let mut drafts = BTreeMap::new();
        for (name, mesh) in self.document.meshes().iter() {
            let known = self.drafts.remove(name).filter(|of| of.version == mesh.version());
            let made = || {
                let bytes = mesh.to_file().ok()?.into();
                Some(Draft { bytes, version: mesh.version() })
            };
            drafts.extend(known.or_else(made).map(|draft| (name.to_owned(), draft)));
        }
        self.drafts = drafts;
        self.drafts.clone().into_iter().collect()
    }

    /// Writes meshes that are no files yet to new files. If a file has taken the name of one meanwhile, it
    /// gets another one.
    fn save_meshes(&mut self, folder: &Path) -> Result<(), String> {
        self.drafts();
        for (name, Draft { bytes, .. }) in self.drafts.clone() {
            let text = self.document.text();
            if renamed(text, &name, &name).1 == 0 {
                continue;
            }
            let is_same = std::fs::read(folder.join(&name)).is_ok_and(|there| *there == *bytes);
            if is_same {
                continue;
            }
            let mut free = name.clone();
            if folder.join(&name).exists() {
                free = free_name(&name, |name| self.is_free(name));
                let edits = renamed(text, &name, &free).0;
                self.document.change(edits, "another name of a mesh", false)?;
            }
            write_new(&folder.join(&free), |file| file.write_all(&bytes))
                .map_err(|error| format!("can't save the mesh `{free}`: {error}"))?;
            self.is_stale = true;
        }
        self.is_stale |= !self.drafts.is_empty();
        Ok(())
    }
}
