//! What one shutter sees: everything a frame needs, immutable, shared by all threads.

use crate::accel::Isa;
use crate::scene::SceneDescription;

/// A scene as one shutter sees it.
#[derive(Debug)]
pub struct FrameScene {}

/// Why a frame of a scene can't be made: in words for the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FrameError(pub String);

impl FrameScene {
    /// Builds what frame `number` needs.
    ///
    /// # Errors
    /// The frame's time lies in no camera segment.
    pub fn build(_scene: &SceneDescription, _number: i64, _isa: Isa) -> Result<Self, FrameError> {
        Ok(Self {})
    }

    /// Bytes of the structures and tables.
    pub fn memory(&self) -> usize {
        0
    }
}
