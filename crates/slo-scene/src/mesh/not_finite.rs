//! Vertices that are NaN or infinite, which matter only if a face has them.

use glam::DVec3;

use super::normals::corners;
use crate::format::FileError;

/// Vertices whose places are kept for a message.
const KEPT: usize = 100;

/// What is wrong with the first of them.
#[derive(Clone, Debug, Default)]
pub(super) struct NotFinite {
    kept: Vec<(usize, FileError)>,
    is_any: bool,
}

impl NotFinite {
    /// Takes note of a vertex.
    pub(super) fn note(&mut self, vertex: usize, error: impl FnOnce() -> FileError) {
        self.is_any = true;
        if self.kept.len() < KEPT && self.kept.last().is_none_or(|(last, _)| *last != vertex) {
            self.kept.push((vertex, error()));
        }
    }

    /// Refuses faces of such vertices.
    ///
    /// # Errors
    /// What is wrong with a vertex of the first such face.
    pub(super) fn check(self, positions: &[DVec3], faces: &[[u32; 3]]) -> Result<(), FileError> {
        if !self.is_any {
            return Ok(());
        }
        let is_finite = |face: &&[u32; 3]| corners(positions, **face).iter().all(|p| p.is_finite());
        let Some(face) = faces.iter().find(|face| !is_finite(face)) else { return Ok(()) };
        let vertex = face.iter().map(|&v| v as usize).find(|&v| !positions[v].is_finite());
        let kept = self.kept.into_iter().find(|(kept, _)| Some(*kept) == vertex);
        Err(kept.map_or_else(
            || {
                let vertex = vertex.unwrap_or_default();
                FileError::whole_file(format!("vertex {vertex} of a face is not finite"))
            },
            |(_, error)| error,
        ))
    }
}
