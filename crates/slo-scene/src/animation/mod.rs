//! Bézier curves, key frames, the clock (frame -> shutter -> scene time).
//!
//! Three times meet here, and only here:
//!
//! - *video time*: seconds of the finished video; frame `N` opens its shutter at `N / fps`;
//! - *scene time*: what key frames count in; a camera segment maps video time to it linearly;
//! - *shutter time*: `[0, 1]` over one shutter; what a ray carries.

mod affine;
mod bezier;
mod camera_path;
mod changing;
mod clock;
mod key_frames;
mod mix;
mod orientation;
mod path;
mod piece;
mod placed;
mod repeat;
mod rigid;

pub use affine::DAffine;
pub use bezier::{bezier, cubic};
pub use camera_path::{View, axes, between, view_at};
pub use changing::hash_of_shapes;
pub use clock::{Clock, NoSegment, SegmentFrames, Shutter};
pub use key_frames::{Jump, KeyFrameError, KeyFrames};
pub use mix::mix;
pub use orientation::{about, have_orientation, sin_cos_deg};
pub use path::{Path, Spaces};
pub use placed::placed;
pub use rigid::DRigid;
