//! Scenes: opened, parsed, or built in memory.

use std::fmt::{self, Write};
use std::fs;
use std::ops::RangeInclusive;
use std::path::Path;

use slo_scene::animation::Clock;
use slo_scene::diagnostics::Diagnostics;
use slo_scene::{Files, Loaded, SceneDescription, load};

use crate::error::Error;

/// A scene without errors, with all of its meshes and images.
#[derive(Clone, Debug)]
pub struct Scene {
    description: SceneDescription,
    warnings: Diagnostics,
}

impl Scene {
    /// Opens a scene file. Paths of meshes and images start in the folder of the scene, and may
    /// lead anywhere. For scenes from strangers, use [`open_within`](Self::open_within).
    ///
    /// # Errors
    /// [`Error::Io`] if the file cannot be read, and [`Error::Scene`] if the scene has errors, or
    /// a mesh or an image cannot be used.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        Self::read(path, folder(path), true)
    }

    /// Opens a scene file whose meshes and images must lie in the folder `root`.
    ///
    /// # Errors
    /// The errors of [`open`](Self::open). A path that leaves `root` is an error of the scene.
    pub fn open_within(path: impl AsRef<Path>, root: impl AsRef<Path>) -> Result<Self, Error> {
        Self::read(path.as_ref(), root.as_ref(), false)
    }

    /// Parses scene text. Paths of meshes and images start in `folder`, and may lead anywhere.
    ///
    /// # Errors
    /// [`Error::Scene`], as for [`open`](Self::open).
    pub fn parse(text: &str, folder: impl AsRef<Path>) -> Result<Self, Error> {
        let folder = folder.as_ref();
        Self::from_loaded(load("scene", text, &Files::on_disk(folder, folder, true)))
    }

    /// A scene that was built in memory. Its `content_hash`, by which recipes know it, is computed from
    /// everything that it says.
    ///
    /// # Errors
    /// [`Error::Description`] if a reference or an index leads nowhere.
    pub fn from_description(mut description: SceneDescription) -> Result<Self, Error> {
        description.check().map_err(Error::Description)?;
        description.content_hash = [0; 32];
        let mut hasher = Hasher(blake3::Hasher::new());
        // Writing to a hash cannot fail.
        let _ = write!(hasher, "{description:?}");
        description.content_hash = *hasher.0.finalize().as_bytes();
        Ok(Self { description, warnings: Diagnostics::default() })
    }

    /// Returns what the scene says: settings, camera, lights, materials and objects as plain data.
    pub fn description(&self) -> &SceneDescription {
        &self.description
    }

    /// Returns the warnings about the scene's text.
    pub fn warnings(&self) -> &Diagnostics {
        &self.warnings
    }

    /// Returns the frames of each camera segment, in order of time.
    pub fn frames(&self) -> Vec<RangeInclusive<i64>> {
        Clock::new(&self.description.camera).segments().map(|s| s.first..=s.last).collect()
    }

    fn read(path: &Path, root: &Path, allow_outside: bool) -> Result<Self, Error> {
        let text = fs::read(path).map_err(|source| Error::Io { path: path.into(), source })?;
        let files = Files::on_disk(folder(path), root, allow_outside);
        Self::from_loaded(load(&path.to_string_lossy(), text, &files))
    }

    fn from_loaded(Loaded { scene, diagnostics }: Loaded) -> Result<Self, Error> {
        match scene {
            Some(description) => Ok(Self { description, warnings: diagnostics }),
            None => Err(Error::Scene(diagnostics)),
        }
    }
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Hashes text as it is written.
struct Hasher(blake3::Hasher);

impl fmt::Write for Hasher {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.update(text.as_bytes());
        Ok(())
    }
}
