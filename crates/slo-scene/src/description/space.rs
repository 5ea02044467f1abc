//! Spaces that things hang in.

use crate::key_frame::{KeyFrame, SpaceId};
use crate::settings::Repeat;

/// The space of a `group`, or of an object or a lamp that others have as their `parent`.
#[derive(Clone, Debug)]
pub struct Space {
    /// The name in the text.
    pub name: String,
    /// In order of time: how the space moves in its parent.
    pub key_frames: Vec<KeyFrame>,
    /// How its motion goes on before the first and after the last; `None`: not at all.
    pub repeat: Option<Repeat>,
    /// What the space hangs in; `None`: scene space. Spaces never hang in rings.
    pub parent: Option<SpaceId>,
    /// Whether all that hangs in it is left out of the picture, directly or by other spaces. Copies
    /// of it are not.
    pub hidden: bool,
}
