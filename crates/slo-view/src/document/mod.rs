//! The text of the scene: as it is on disk, as it has been changed, and every change back to the start.

mod history;
mod lines;

use std::io::{self, Write};
use std::path::Path;

use slo_picture::output::write_atomically;
use slo_scene::edit::{Edit, applied};

use crate::sculpting::Sculptures;

use history::{History, State};
pub(crate) use lines::{Hunk, differences, merged};

/// What text files of some programs begin with.
const BYTE_ORDER_MARK: &str = "\u{feff}";

/// The text of the scene.
#[derive(Debug, Default)]
pub(crate) struct Document {
    /// As it is on disk, as far as is known.
    saved: String,
    text: String,
    /// Whether the file begins with a byte order mark, which the texts here do without.
    is_marked: bool,
    /// What is on disk, if both it and the text have been changed in the same lines.
    conflict: Option<String>,
    /// Meshes that the text names and that are no files yet.
    meshes: Sculptures,
    history: History,
}

/// What a change on disk means for the text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outside {
    /// The file says what it said.
    Nothing,
    /// The text is another one.
    Taken,
    /// The person has to choose.
    Conflict,
}

impl Document {
    /// The text.
    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    /// The bytes of a file of the text.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        let mark = if self.is_marked { BYTE_ORDER_MARK } else { "" };
        [mark, &self.text].concat().into_bytes()
    }

    /// Whether the text differs from the file, or meshes of it are not saved.
    pub(crate) fn is_changed(&self) -> bool {
        self.text != self.saved || !self.meshes.is_empty()
    }

    /// Meshes that are no files yet.
    pub(crate) fn meshes(&self) -> &Sculptures {
        &self.meshes
    }

    /// Whether the person has to choose between the text and the file.
    pub(crate) fn has_conflict(&self) -> bool {
        self.conflict.is_some()
    }

    /// The lines that differ from the file.
    pub(crate) fn differences(&self) -> Vec<Hunk> {
        differences(&self.saved, &self.text)
    }

    /// What the next undo takes back, and the next redo repeats.
    pub(crate) fn next(&self) -> [Option<&str>; 2] {
        self.history.next()
    }

    /// Takes what is on disk. Changes of the text are kept if they are in other lines.
    pub(crate) fn read(&mut self, file: &str) -> Outside {
        let (is_marked, file) = match file.strip_prefix(BYTE_ORDER_MARK) {
            Some(file) => (true, file),
            None => (false, file),
        };
        self.is_marked = is_marked;
        if file == self.saved && self.conflict.is_none() {
            return Outside::Nothing;
        }
        let text = if self.is_changed() {
            merged(&self.saved, &self.text, file)
        } else {
            Some(file.into())
        };
        let Some(text) = text else {
            self.conflict = Some(file.to_owned());
            return Outside::Conflict;
        };
        let was_changed = self.is_changed();
        (self.saved, self.conflict) = (file.to_owned(), None);
        if was_changed {
            self.become_text(text, "the change of the file", false);
        } else {
            // What somebody else has written is not taken back here.
            (self.text, self.history) = (text, History::default());
        }
        Outside::Taken
    }

    /// Changes the text. Changes with the same words that follow one another are one step if they `join`.
    ///
    /// # Errors
    /// They do not fit the text.
    pub(crate) fn change(
        &mut self,
        edits: Vec<Edit>,
        what: &str,
        join: bool,
    ) -> Result<(), String> {
        let text = applied(&self.text, edits).ok_or("the text has changed meanwhile")?;
        self.become_text(text, what, join);
        Ok(())
    }

    /// Takes another text. Changes with the same words that follow one another are one step if they
    /// `join`.
    pub(crate) fn replace(&mut self, text: String, what: &str, join: bool) {
        self.become_text(text, what, join);
    }

    /// Takes another text, and meshes that it names and that are no files yet.
    pub(crate) fn sculpt(&mut self, text: String, meshes: Sculptures, what: &str, join: bool) {
        self.become_state(text, meshes, what, join);
    }

    /// No later change joins the last one.
    pub(crate) fn seal(&mut self) {
        self.history.seal();
    }

    /// Takes a change back; false if there is none.
    pub(crate) fn undo(&mut self) -> bool {
        self.history.undo(&mut self.text, &mut self.meshes)
    }

    /// Repeats a change that was taken back; false if there is none.
    pub(crate) fn redo(&mut self) -> bool {
        self.history.redo(&mut self.text, &mut self.meshes)
    }

    /// Returns to what is on disk.
    pub(crate) fn revert(&mut self) {
        if let Some(file) = self.conflict.take() {
            self.saved = file;
        }
        let saved = self.saved.clone();
        self.become_state(saved, Sculptures::default(), "the return to the file", false);
    }

    /// Keeps the text, whatever is on disk.
    pub(crate) fn keep(&mut self) {
        if let Some(file) = self.conflict.take() {
            self.saved = file;
        }
    }

    /// Checks whether the file is as it is known.
    ///
    /// # Errors
    /// Somebody has changed it meanwhile, or it can't be read or written.
    pub(crate) fn check(&self, path: &Path) -> Result<(), String> {
        let cant = |error: io::Error| format!("can't save the scene: {error}");
        let now = match std::fs::read(path) {
            // The file is gone, so saving loses nothing of another program.
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
            now => now.map_err(cant)?,
        };
        let now = String::from_utf8_lossy(&now);
        if self.has_conflict() || now.strip_prefix(BYTE_ORDER_MARK).unwrap_or(&now) != self.saved {
            return Err("the file has been changed by another program".into());
        }
        if path.metadata().map_err(cant)?.permissions().readonly() {
            return Err("can't save the scene: the file is read-only".into());
        }
        Ok(())
    }

    /// Writes the text to its file, which is complete or as it was at any moment.
    ///
    /// # Errors
    /// Somebody has changed the file meanwhile, or it can't be written.
    pub(crate) fn save(&mut self, path: &Path) -> Result<(), String> {
        self.check(path)?;
        let cant = |error: io::Error| format!("can't save the scene: {error}");
        if !path.exists() {
            return self.save_anew(path);
        }
        // A link stays a link, and the file keeps what its owner allows.
        let path = path.canonicalize().map_err(cant)?;
        let permissions = path.metadata().map_err(cant)?.permissions();
        let bytes = self.bytes();
        write_atomically(&path, |file| {
            file.set_permissions(permissions)?;
            file.write_all(&bytes)
        })
        .map_err(cant)?;
        self.saved.clone_from(&self.text);
        Ok(())
    }

    /// Writes the text to a file that is not there.
    fn save_anew(&mut self, path: &Path) -> Result<(), String> {
        let bytes = self.bytes();
        write_atomically(path, |file| file.write_all(&bytes))
            .map_err(|error| format!("can't save the scene: {error}"))?;
        self.saved.clone_from(&self.text);
        Ok(())
    }

    /// The meshes that the text names are files now.
    pub(crate) fn keep_meshes(&mut self) {
        self.meshes = Sculptures::default();
    }

    fn become_text(&mut self, text: String, what: &str, join: bool) {
        self.become_state(text, self.meshes.clone(), what, join);
    }

    fn become_state(&mut self, text: String, meshes: Sculptures, what: &str, join: bool) {
        let [old, new] = [(&self.text, &self.meshes), (&text, &meshes)]
            .map(|(text, meshes)| State { text, meshes });
        if text != self.text || meshes != self.meshes {
            self.history.add(old, new, what, join);
            (self.text, self.meshes) = (text, meshes);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn document(file: &str) -> Document {
        let mut document = Document::default();
        document.read(file);
        document
    }

    fn replace(document: &mut Document, old: &str, new: &str, join: bool) {
        let start = document.text().find(old).expect("it is there");
        let edit = Edit { range: start..start + old.len(), text: new.into() };
        document.change(vec![edit], old, join).expect("it fits");
    }

    #[test]
    fn changes_go_back_and_forth() {
        let mut document = document("a b c");
        assert!(!document.is_changed() && !document.has_conflict());
        replace(&mut document, "b", "x", false);
        replace(&mut document, "c", "y", false);
        assert_eq!((document.text(), document.is_changed()), ("a x y", true));
        assert_eq!(document.next(), [Some("c"), None]);
        assert!(document.undo() && document.text() == "a x c");
        assert!(document.undo() && document.text() == "a b c" && !document.is_changed());
        assert!(document.redo() && document.text() == "a x c");
        replace(&mut document, "a", "z", false);
        assert!(!document.redo());
        document.revert();
        assert_eq!(document.text(), "a b c");
        assert!(document.undo() && document.text() == "z x c");
    }

    #[test]
    fn changes_of_a_movement_are_one_step() {
        let mut document = document("1");
        for (old, new) in [("1", "2"), ("2", "3")] {
            let edit = Edit { range: 0..old.len(), text: new.into() };
            document.change(vec![edit], "camera", true).expect("it fits");
        }
        assert_eq!(document.text(), "3");
        assert!(document.undo() && document.text() == "1" && !document.undo());
    }

    #[test]
    fn changes_of_others_are_merged_or_asked_about() {
        let mut document = document("a\nb\nc\nd\n");
        replace(&mut document, "b", "x", false);
        assert_eq!(document.read("a\nb\nc\ny\n"), Outside::Taken);
        assert_eq!(document.text(), "a\nx\nc\ny\n");
        assert_eq!(document.read("a\nb\nc\ny\n"), Outside::Nothing);
        assert_eq!(document.read("a\nz\nc\ny\n"), Outside::Conflict);
        assert!(document.has_conflict());
        document.keep();
        assert_eq!((document.text(), document.has_conflict()), ("a\nx\nc\ny\n", false));
        assert_eq!(document.read("a\nv\nc\ny\n"), Outside::Conflict);
        document.revert();
        assert_eq!((document.text(), document.is_changed()), ("a\nv\nc\ny\n", false));
    }

    #[test]
    fn files_are_saved_unless_they_have_changed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.txt");
        std::fs::write(&path, "\u{feff}a b\r\n").unwrap();
        let mut document = document("\u{feff}a b\r\n");
        replace(&mut document, "b", "c", false);
        document.save(&path).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "\u{feff}a c\r\n");
        assert!(!document.is_changed());
        replace(&mut document, "c", "d", false);
        std::fs::write(&path, "else").unwrap();
        assert!(document.save(&path).unwrap_err().contains("another program"));
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "else");
        std::fs::remove_file(&path).unwrap();
        document.save(&path).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "\u{feff}a d\r\n");
        assert_eq!(folder.path().read_dir().unwrap().count(), 1);
    }
}
