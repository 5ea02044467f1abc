//! Where the scene comes from.

use std::io;
use std::path::Path;

use slo_scene::files::Opened;
use slo_scene::{KnownFiles, Loaded};

/// A scene that can be read again, and whose text can be changed.
pub trait Source: Send {
    /// What messages call the scene: its path as the user gave it.
    fn name(&self) -> String;

    /// The file of the scene; `None` if it has none, so that it can't be saved.
    fn path(&self) -> Option<&Path>;

    /// Reads the text.
    ///
    /// # Errors
    /// Any I/O error.
    fn read(&self) -> io::Result<Vec<u8>>;

    /// Loads the scene that a text describes, and notes the files that it names. `known` is what scenes
    /// before it have left.
    fn load(&self, text: &[u8], opened: &Opened, known: &KnownFiles) -> Loaded;
}
