//! Where the scene comes from.

use std::io;
use std::path::Path;

use slo_scene::files::{Drafts, Opened};
use slo_scene::{KnownFiles, Loaded};

/// A scene that can be read again, and whose text can be changed.
pub trait Source: Send {
    /// What messages call the scene: its path as the user gave it.
    fn name(&self) -> String;

    /// The file of the scene; `None` if it has none, so that it can't be saved.
    fn path(&self) -> Option<&Path>;

    /// The command that explains a pixel of a frame of the scene as the program does. `size` is that of the
    /// picture, if it is not the scene's.
    fn replay(&self, pixel: [u32; 2], frame: i64, size: Option<[u32; 2]>) -> String;

    /// Reads the text.
    ///
    /// # Errors
    /// Any I/O error.
    fn read(&self) -> io::Result<Vec<u8>>;

    /// Reads another file, by its path as a scene writes it.
    ///
    /// # Errors
    /// It can't be read, or the scene may not read it; with what to say about it.
    fn open(&self, path: &str) -> Result<Vec<u8>, String>;

    /// Loads the scene that a text describes, and notes the files that it names. `known` is what scenes
    /// before it have left, and `drafts` are files that are not on disk yet.
    fn load(&self, text: &[u8], opened: &Opened, known: &KnownFiles, drafts: &Drafts) -> Loaded;
}
