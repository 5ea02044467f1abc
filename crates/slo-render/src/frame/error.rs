//! Why a frame cannot be built.

use std::fmt;

use super::lamps::LampFault;
use crate::camera::DegenerateView;
use slo_scene::ShapeError;
use slo_scene::animation::{KeyFrameError, NoSegment};
use slo_scene::{MOST_COPIED, MOST_NESTED, MOST_SHOWN};

/// Why a frame of a scene cannot be built.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum FrameError {
    /// The frame's time lies in no camera segment.
    NoSegment(NoSegment),
    /// Nothing can be seen from the camera's view in this frame.
    View {
        /// Name of the camera segment.
        segment: String,
        /// What is wrong.
        reason: DegenerateView,
    },
    /// A shape of a mesh cannot be used.
    Shape {
        /// Name of the object.
        object: String,
        /// What is wrong.
        reason: ShapeError,
    },
    /// An object's key frames do not form a path.
    Path {
        /// Name of the object.
        object: String,
        /// What is wrong.
        reason: KeyFrameError,
    },
    /// A lamp cannot be where the spaces take it that it hangs in.
    Lamp {
        /// Name of the lamp.
        lamp: String,
        /// What is wrong.
        reason: LampFault,
    },
    /// Copies are nested too deeply, or hold themselves.
    Nested {
        /// Name of one of them.
        copy: String,
    },
    /// There are too many copies.
    Copies,
    /// There is not enough memory.
    Memory {
        /// What needs it, with its verb.
        what: &'static str,
        /// How much it needs, and how much there is.
        why: String,
        /// What would need less.
        help: &'static str,
    },
    /// An object is scaled so much, or so little, that numbers cannot hold it.
    Extent {
        /// Name of the object or lamp.
        object: String,
    },
    /// The rays of the frame cannot be counted.
    Uncounted {
        /// Why, as a sentence.
        reason: &'static str,
    },
    /// The GPU that the settings ask for is missing, or cannot take the scene.
    Device {
        /// Name of the structure.
        accelerator: &'static str,
        /// What is wrong.
        reason: String,
    },
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoSegment(error) => error.fmt(f),
            Self::Shape { object, reason } => write!(f, "mesh `{object}`: {reason}"),
            Self::View { segment, reason } => {
                write!(f, "the camera of segment `{segment}` can't see in this frame: ")?;
                f.write_str(match reason {
                    DegenerateView::NoDirection => "its position and its target are the same point",
                    DegenerateView::SkyAlongView => {
                        "its sky is zero or parallel to its direction of view"
                    }
                })
            }
            Self::Path { object, reason: KeyFrameError::NoOrientation(key) } => {
                write!(f, "key frame {} of `{object}`: up is parallel to right", key + 1)
            }
            Self::Path { object, reason: KeyFrameError::OutOfOrder(key) } => {
                write!(f, "key frame {} of `{object}` is earlier than the one before it", key + 1)
            }
            Self::Lamp { lamp, reason: LampFault::Sheared } => write!(
                f,
                "what lamp `{lamp}` hangs in stretches it out of shape: a rectangle must keep its \
                 right angles, and a disc must stay round"
            ),
            Self::Lamp { lamp, reason: LampFault::Grows } => write!(
                f,
                "lamp `{lamp}` changes its size while the shutter is open: only its place and its \
                 direction may change then"
            ),
            Self::Nested { copy } => {
                write!(f, "more than {MOST_NESTED} copies are nested in one another: `{copy}`")
            }
            Self::Copies => write!(
                f,
                "the frame shows more than {MOST_SHOWN} things, copies included, or more than \
                 {MOST_COPIED} that are no plain copies: lamps, things that glow or change shape, \
                 and things that move by themselves"
            ),
            Self::Memory { what, why, .. } => write!(f, "{what} {why}"),
            Self::Extent { object } => write!(
                f,
                "`{object}` is too large or too small in this frame: all its scales together must \
                 be from 1e-12 to 1e12, and its coordinates below 1e10"
            ),
            Self::Uncounted { reason } => f.write_str(reason),
            Self::Device { accelerator, reason } => {
                write!(f, "accelerator {accelerator}: {reason}")
            }
        }
    }
}

impl std::error::Error for FrameError {}
