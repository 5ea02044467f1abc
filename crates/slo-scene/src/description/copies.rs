//! Copies: other places for things that are there already.

use std::sync::Arc;

use super::{KeyFrame, MaterialId, SpaceId};
use crate::placements::Placements;
use crate::settings::Repeat;

/// What a copy shows, without its own place: the copy's takes its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Original {
    /// The object with this index.
    Object(u32),
    /// The light with this index.
    Light(u32),
    /// All that hangs in a space, in others that hang in it, and so on; without what is hidden.
    Group(SpaceId),
    /// The copy with this index.
    Copy(u32),
}

/// `copy` or `copies`: the same things in other places.
#[derive(Clone, Debug)]
pub struct Copy {
    /// The name in the text.
    pub name: String,
    /// What is shown; of `copies`, the [kind](Placements::kind) of each placement chooses.
    pub of: Vec<Original>,
    /// In order of time: how the copies move together in their parent.
    pub key_frames: Vec<KeyFrame>,
    /// How their motion goes on before the first and after the last; `None`: not at all.
    pub repeat: Option<Repeat>,
    /// What they hang in; `None`: scene space.
    pub parent: Option<SpaceId>,
    /// Where they are in the space of these key frames; `None`: one copy at the origin.
    pub placements: Option<Arc<Placements>>,
    /// The material of everything in them; `None`: what the originals are made of.
    pub material: Option<MaterialId>,
    /// Whether they are left out of the picture. Copies of them are not.
    pub hidden: bool,
}

/// Most things that a scene may show, copies included.
pub const MOST_SHOWN: u64 = 4_000_000_000;

/// Most things that a frame may show one by one: all lamps, and whatever needs something of its own.
pub const MOST_COPIED: u64 = 10_000_000;

/// Most copies that may be nested in one another.
pub const MOST_NESTED: u32 = 8;
