//! Meshes that change shape: files that give the positions of one mesh at several times.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::RangeInclusive;
use std::sync::{Arc, Mutex, PoisonError};

use crate::assets::Standing;
use crate::attributes::FARTHEST;
use crate::files::{Files, HashingReader, OpenError, hash_whole};
use crate::format::FileError;
use crate::mesh::{self, Mesh};

/// The shapes of a mesh at scene times. A file is read when a shutter needs it.
///
/// Between two times, positions and normals move straight and evenly; before the first time and
/// after the last, the mesh is at rest.
#[derive(Clone)]
pub struct MeshShapes {
    files: Files,
    /// Times, ascending, and paths.
    keys: Vec<(f64, String)>,
    standing: Standing,
    /// `Scaling`.
    scale: f64,
    /// The path of the mesh whose faces all shapes have.
    first: String,
    /// Shapes that the last shutter needed, by place among the keys.
    kept: Arc<Mutex<Vec<Kept>>>,
    /// Hashes of the files that were asked for or read, by place among the keys.
    hashes: Arc<Mutex<BTreeMap<usize, blake3::Hash>>>,
}

/// A shape that was read, by its place among the keys.
type Kept = (usize, Arc<Mesh>);

/// A shape at a scene time.
#[derive(Clone, Debug)]
pub struct ShapeAt {
    /// Scene time.
    pub time: f64,
    /// The mesh at that time; its faces are those of all others.
    pub mesh: Arc<Mesh>,
}

/// Why a shape cannot be used.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum ShapeError {
    /// A file is not there, or cannot be read.
    Unreadable {
        /// Its path, as the scene writes it.
        path: String,
        /// What is wrong.
        reason: String,
    },
    /// A file is wrong.
    Wrong {
        /// Its path, as the scene writes it.
        path: String,
        /// What is wrong.
        reason: Box<FileError>,
    },
    /// A file is no longer what it was when the frame was begun.
    Changed {
        /// Its path, as the scene writes it.
        path: String,
    },
    /// Two files have different faces.
    Differs {
        /// The path of the mesh.
        first: String,
        /// The path of the other shape.
        other: String,
        /// How they differ.
        how: String,
    },
}

impl fmt::Debug for MeshShapes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("MeshShapes").field("keys", &self.keys).finish_non_exhaustive()
    }
}

impl fmt::Display for ShapeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable { path, reason } => write!(f, "file `{path}` {reason}"),
            Self::Wrong { path, reason } if reason.line > 0 => {
                write!(f, "file `{path}`, line {}: {}", reason.line, reason.message)
            }
            Self::Wrong { path, reason } => write!(f, "file `{path}`: {}", reason.message),
            Self::Changed { path } => {
                write!(f, "file `{path}` changed while the program was running; start it again")
            }
            Self::Differs { first, other, how } => write!(
                f,
                "`{first}` and `{other}` are not shapes of one mesh: {how}; all shapes need the \
                 same vertices and the same faces, in the same order"
            ),
        }
    }
}

impl std::error::Error for ShapeError {}

impl MeshShapes {
    /// Shapes in ascending order of time, of the mesh at the path `first`.
    pub(crate) fn new(
        files: &Files,
        keys: Vec<(f64, String)>,
        standing: Standing,
        scale: f64,
        first: String,
    ) -> Self {
        Self {
            files: files.clone(),
            keys,
            standing,
            scale,
            first,
            kept: Arc::default(),
            hashes: Arc::default(),
        }
    }

    /// The times and paths of the shapes, in order of time.
    pub fn keys(&self) -> impl Iterator<Item = (f64, &str)> {
        self.keys.iter().map(|(time, path)| (*time, path.as_str()))
    }

    /// The shapes that tell where `mesh` is from the earlier to the later of two scene times, in
    /// order of time: those in between, and one on each side. Reads files that are not known from
    /// the call before.
    ///
    /// # Errors
    /// A file cannot be read, or has other faces than `mesh`.
    pub fn within(&self, interval: [f64; 2], mesh: &Mesh) -> Result<Vec<ShapeAt>, ShapeError> {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let mut needed = Vec::new();
        for i in self.needed(interval) {
            let known = kept.iter().find(|(place, _)| *place == i).map(|(_, mesh)| mesh.clone());
            needed.push((i, known.map_or_else(|| self.read(i, mesh).map(Arc::new), Ok)?));
        }
        kept.clone_from(&needed);
        let at = |(i, mesh): (usize, Arc<Mesh>)| ShapeAt { time: self.keys[i].0, mesh };
        Ok(needed.into_iter().map(at).collect())
    }

    /// Adds to `hasher` the content of the files that the shapes of [`within`](Self::within) are
    /// read from. Files that cannot be read add nothing: `within` reports them. It also reports
    /// files that change after they were hashed.
    pub fn hash_within(&self, interval: [f64; 2], hasher: &mut blake3::Hasher) {
        for place in self.needed(interval) {
            let known = self.hashes().get(&place).copied();
            let hash = known.or_else(|| {
                let hash = hash_whole(self.files.open(&self.keys[place].1).ok()?).ok()?.finalize();
                self.hashes().insert(place, hash);
                Some(hash)
            });
            if let Some(hash) = hash {
                hasher.update(hash.as_bytes());
            }
        }
    }

    /// The places of the shapes that tell where the mesh is between two scene times.
    fn needed(&self, interval: [f64; 2]) -> RangeInclusive<usize> {
        let [start, end] = [interval[0].min(interval[1]), interval[0].max(interval[1])];
        let first = self.keys.partition_point(|key| key.0 <= start).saturating_sub(1);
        let last = self.keys.partition_point(|key| key.0 < end).min(self.keys.len() - 1);
        // If the last shape is reached before the shutter opens, only this one counts.
        first..=last.max(first)
    }

    fn hashes(&self) -> std::sync::MutexGuard<'_, BTreeMap<usize, blake3::Hash>> {
        self.hashes.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn read(&self, place: usize, whole: &Mesh) -> Result<Mesh, ShapeError> {
        let path = &self.keys[place].1;
        let wrong = |reason| ShapeError::Wrong { path: path.clone(), reason: Box::new(reason) };
        let unreadable = |error: &OpenError| ShapeError::Unreadable {
            path: path.clone(),
            reason: reason(error),
        };
        let reader = self.files.open(path).map_err(|error| unreadable(&error))?;
        let mut reader = HashingReader::new(reader);
        let loaded = mesh::load_shape(path, &mut reader, self.standing.smooth, self.scale);
        let mut mesh = loaded.map_err(wrong)?.mesh;
        let read = reader.finish().map_err(|error| unreadable(&OpenError::Unreadable(error)))?;
        let read = read.finalize();
        if *self.hashes().entry(place).or_insert(read) != read {
            return Err(ShapeError::Changed { path: path.clone() });
        }
        mesh.stand_up(self.standing.axes);
        if mesh.positions.iter().any(|p| p.abs().max_element() > FARTHEST) {
            let message = format!("vertices lie farther out than {FARTHEST:e}");
            return Err(wrong(FileError::whole_file(message)));
        }
        match difference(whole, &mesh) {
            None => Ok(mesh),
            Some(how) => {
                let (first, other) = (self.first.clone(), path.clone());
                Err(ShapeError::Differs { first, other, how })
            }
        }
    }
}

/// How two meshes differ that should have the same faces.
fn difference(first: &Mesh, other: &Mesh) -> Option<String> {
    let numbers = [
        ("faces", first.faces.len(), other.faces.len()),
        ("vertices", first.positions.len(), other.positions.len()),
    ];
    if let Some((what, a, b)) = numbers.into_iter().find(|(_, a, b)| a != b) {
        return Some(format!("they have {a} and {b} {what}"));
    }
    let face = first.faces.iter().zip(&other.faces).position(|(a, b)| a != b)?;
    Some(format!("face {face} has other vertices"))
}

fn reason(error: &OpenError) -> String {
    match error {
        OpenError::Spelling(better) => format!("is written with `\\`: write `{better}`"),
        OpenError::Outside => "leaves the input folder".to_owned(),
        OpenError::Missing(_) => "not found".to_owned(),
        OpenError::Unreadable(error) => format!("can't be read: {}", error),
    }
}
