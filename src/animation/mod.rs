//! Bézier curves, key frames, the clock (frame -> shutter -> scene time), sampled transforms.
//!
//! Three times meet here, and only here:
//!
//! - *video time*: seconds of the finished video; frame `N` opens its shutter at `N / fps`;
//! - *scene time*: what key frames count in; a camera segment maps video time to it linearly;
//! - *shutter time*: `[0, 1]` over one shutter; what a ray carries.

mod bezier;
mod camera_path;
mod clock;
mod key_frames;
mod orientation;
mod piece;
mod sampled_camera;
mod sampled_motion;

pub use bezier::{bezier, cubic};
pub use camera_path::view_at;
pub use clock::{Clock, NoSegment, SegmentFrames, Shutter};
pub use key_frames::{Jump, KeyFrameError, KeyFrames};
pub use orientation::have_orientation;
pub use sampled_camera::SampledCamera;
pub use sampled_motion::{ObjectBox, SampledMotion};

/// Most samples of one path over one shutter. An object that sweeps the whole height of a picture
/// of 8192 pixels once needs as many; faster motion is sampled this finely and no finer.
pub const MAX_SAMPLES: usize = 16384;

/// `a` at 0 and `b` at 1, exactly; also exactly `a` all the way where both are equal.
fn mix(a: f64, b: f64, u: f64) -> f64 {
    if u == 1.0 { b } else { a + (b - a) * u }
}

/// Shutter time of sample `k` of `count`.
fn time_of(k: usize, count: usize) -> f64 {
    k as f64 / (count - 1) as f64
}

fn least_count(shutter: &Shutter, samples_per_ms: f64) -> usize {
    let asked = (samples_per_ms * shutter.duration() * 1e3).ceil();
    (asked as usize).clamp(2, MAX_SAMPLES)
}
