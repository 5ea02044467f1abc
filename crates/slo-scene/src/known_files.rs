//! Meshes and images that were loaded before, for as long as their files stay as they are.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::SystemTime;

use crate::mesh::Mesh;
use crate::settings::Axes;
use crate::texture::Texture;

/// How many loads a thing outlives that no scene has used.
const ROUNDS: u64 = 8;

/// Remembers the meshes and images of scenes that are loaded again and again while their texts change.
/// What it returns is what the files hold, as far as their times and lengths tell.
#[derive(Clone, Debug, Default)]
pub struct KnownFiles(Arc<Mutex<Entries>>);

#[derive(Debug, Default)]
struct Entries {
    round: u64,
    meshes: HashMap<MeshKey, Remembered<Mesh>>,
    textures: HashMap<String, Remembered<Texture>>,
}

/// The paths of a mesh, what the scene makes of its files, and its `Scaling`, in bits.
pub(crate) type MeshKey = (Vec<String>, (bool, Axes, Option<u64>), u64);

/// The time and the length of a file.
pub(crate) type Stamp = (SystemTime, u64);

/// What reading a file brought beside its content.
#[derive(Clone, Debug)]
pub(crate) struct Note {
    /// Seen from the folder of the scene.
    pub(crate) path: String,
    /// `None` if it can't be told: the file is read again.
    pub(crate) stamp: Option<Stamp>,
    pub(crate) hash: Option<blake3::Hasher>,
    pub(crate) warnings: Vec<String>,
    pub(crate) lacks_uvs: bool,
}

/// A thing that was loaded.
#[derive(Debug)]
pub(crate) struct Remembered<T> {
    pub(crate) thing: Arc<T>,
    /// Of each of its files.
    pub(crate) notes: Vec<Note>,
    round: u64,
}

impl<T> Clone for Remembered<T> {
    fn clone(&self) -> Self {
        Self { thing: self.thing.clone(), notes: self.notes.clone(), round: self.round }
    }
}

impl Note {
    /// Of a file that is about to be read.
    pub(crate) fn new(path: String, stamp: Option<Stamp>) -> Self {
        Self { path, stamp, hash: None, warnings: Vec::new(), lacks_uvs: false }
    }
}

impl KnownFiles {
    fn entries(&self) -> MutexGuard<'_, Entries> {
        self.0.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    /// Another scene is loaded from now on. What has not been used for long is forgotten.
    pub(crate) fn begin(&self) {
        let mut entries = self.entries();
        entries.round += 1;
        let round = entries.round;
        entries.meshes.retain(|_, known| known.round + ROUNDS >= round);
        entries.textures.retain(|_, known| known.round + ROUNDS >= round);
    }

    pub(crate) fn mesh(&self, key: &MeshKey) -> Option<Remembered<Mesh>> {
        let mut entries = self.entries();
        let round = entries.round;
        let known = entries.meshes.get_mut(key)?;
        known.round = round;
        Some(known.clone())
    }

    pub(crate) fn keep_mesh(&self, key: MeshKey, thing: Arc<Mesh>, notes: Vec<Note>) {
        let mut entries = self.entries();
        let round = entries.round;
        entries.meshes.insert(key, Remembered { thing, notes, round });
    }

    pub(crate) fn texture(&self, path: &str) -> Option<Remembered<Texture>> {
        let mut entries = self.entries();
        let round = entries.round;
        let known = entries.textures.get_mut(path)?;
        known.round = round;
        Some(known.clone())
    }

    pub(crate) fn keep_texture(&self, path: String, thing: Arc<Texture>, note: Note) {
        let mut entries = self.entries();
        let round = entries.round;
        entries.textures.insert(path, Remembered { thing, notes: vec![note], round });
    }
}
